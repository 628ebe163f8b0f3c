"""A unit for model exchange of FMI 3 with arrays, written in C for the tests: x' = A x + B u, y = C x + D u."""

from __future__ import annotations

import subprocess
import zipfile
from pathlib import Path

A, B = ((-1.0, 2.0), (-3.0, -0.5)), ((1.0, 0.0), (0.2, 0.7))
C, D = ((1.0, 0.5), (0.0, -1.0)), ((0.0, 0.3), (0.1, 0.0))

SOURCE = r"""
#include <stdlib.h>
#include <string.h>
#include <stdbool.h>
typedef struct { double t, x[2], u[2], gain[4]; } Unit;
static const double A[4] = {%A}, B[4] = {%B}, C[4] = {%C}, D[4] = {%D};
static void by(Unit *m, const double *P, const double *Q, double *out) {
    for (int i = 0; i < 2; i++)
        out[i] = P[2*i] * m->x[0] + P[2*i+1] * m->x[1] + Q[2*i] * m->u[0] + Q[2*i+1] * m->u[1];
}
static void rates(Unit *m, double *f) {
    double y[2];
    by(m, A, B, y);
    for (int i = 0; i < 2; i++) f[i] = m->gain[2*i] * y[0] + m->gain[2*i+1] * y[1];
}
void *fmi3InstantiateModelExchange(const char *a, const char *b, const char *c, bool d, bool e, void *f, void *g) {
    Unit *m = calloc(1, sizeof *m);
    m->x[0] = 0.4; m->x[1] = -0.2; m->gain[0] = m->gain[3] = 1.0;
    return m;
}
int fmi3GetFloat64(Unit *m, const unsigned *v, size_t n, double *out, size_t k) {
    for (size_t i = 0; i < n; i++) {
        if (v[i] == 0) { *out++ = m->t; continue; }
        if (v[i] == 4) { memcpy(out, m->gain, sizeof m->gain); out += 4; continue; }
        if (v[i] == 1) memcpy(out, m->x, sizeof m->x);
        if (v[i] == 2) rates(m, out);
        if (v[i] == 3) memcpy(out, m->u, sizeof m->u);
        if (v[i] == 5) by(m, C, D, out);
        out += 2;
    }
    return 0;
}
int fmi3SetFloat64(Unit *m, const unsigned *v, size_t n, const double *in, size_t k) {
    if (n != 1) return 3;
    if (v[0] == 1 && k == 2) { memcpy(m->x, in, sizeof m->x); return 0; }
    if (v[0] == 3 && k == 2) { memcpy(m->u, in, sizeof m->u); return 0; }
    if (v[0] == 4 && k == 4) { memcpy(m->gain, in, sizeof m->gain); return 0; }
    return 3;
}
int fmi3SetTime(Unit *m, double t) { m->t = t; return 0; }
int fmi3SetContinuousStates(Unit *m, const double *x, size_t n) { memcpy(m->x, x, n * sizeof *x); return 0; }
int fmi3GetContinuousStates(Unit *m, double *x, size_t n) { memcpy(x, m->x, n * sizeof *x); return 0; }
int fmi3GetNominalsOfContinuousStates(Unit *m, double *x, size_t n) { x[0] = x[1] = 1.0; return 0; }
int fmi3GetContinuousStateDerivatives(Unit *m, double *f, size_t n) { rates(m, f); return 0; }
int fmi3EnterInitializationMode(Unit *m, bool a, double b, double t, bool c, double d) { m->t = t; return 0; }
int fmi3ExitInitializationMode(Unit *m) { return 0; }
int fmi3EnterEventMode(Unit *m) { return 0; }
int fmi3EnterContinuousTimeMode(Unit *m) { return 0; }
int fmi3GetEventIndicators(Unit *m, double *z, size_t n) { return 0; }
int fmi3UpdateDiscreteStates(Unit *m, bool *again, bool *ends, bool *nominals, bool *values, bool *planned, double *t) {
    *again = *ends = *nominals = *values = *planned = false;
    return 0;
}
int fmi3CompletedIntegratorStep(Unit *m, bool a, bool *event, bool *ends) { *event = *ends = false; return 0; }
int fmi3Terminate(Unit *m) { return 0; }
void fmi3FreeInstance(Unit *m) { free(m); }
"""
TWO = '<Dimension start="2"/>'
DESCRIPTION = f"""<fmiModelDescription fmiVersion="3.0" modelName="arrays" instantiationToken="g">
<ModelExchange modelIdentifier="arrays"/><ModelVariables>
<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
<Float64 name="x" valueReference="1" causality="local" variability="continuous" initial="exact" start="0.4 -0.2">{TWO}
</Float64>
<Float64 name="der(x)" valueReference="2" causality="local" variability="continuous" derivative="1"
 initial="calculated">{TWO}</Float64>
<Float64 name="u" valueReference="3" causality="input" variability="continuous" start="0 0">{TWO}</Float64>
<Float64 name="gain" valueReference="4" causality="parameter" variability="fixed" start="1 0 0 1">{TWO}{TWO}</Float64>
<Float64 name="y" valueReference="5" causality="output" variability="continuous" initial="calculated">{TWO}</Float64>
</ModelVariables><ModelStructure><Output valueReference="5"/><ContinuousStateDerivative valueReference="2"/>
</ModelStructure></fmiModelDescription>"""


def build_arrays(folder: Path) -> Path:
    """Compile the unit in a folder and return its path."""
    import fmpy
    from fmpy.fmi3 import FMU3Model

    text = SOURCE
    for name, matrix in (("A", A), ("B", B), ("C", C), ("D", D)):
        text = text.replace(f"%{name}", ", ".join(str(x) for row in matrix for x in row))
    text += "".join(
        f"int {n}(void) {{ return 3; }}\n" for n in dir(FMU3Model) if n.startswith("fmi3") and n not in text
    )
    source, library = folder / "arrays.c", folder / "arrays.so"
    source.write_text(text, encoding="utf-8")
    subprocess.run(["cc", "-shared", "-fPIC", "-w", "-O1", "-o", str(library), str(source)], check=True)
    path = folder / "arrays.fmu"
    with zipfile.ZipFile(path, "w") as unit:
        unit.writestr("modelDescription.xml", DESCRIPTION)
        unit.write(library, f"binaries/{fmpy.platform_tuple}/arrays{fmpy.sharedLibraryExtension}")
    return path
