"""Units for model exchange of FMI 2 and 3, written in C for the tests: an oscillator with an input, a ball, a clock."""

from __future__ import annotations

import shutil
import subprocess
import zipfile
from pathlib import Path

HAS_COMPILER = shutil.which("cc") is not None

COMMON = r"""
#include <stdlib.h>
#include <string.h>
#include <math.h>
typedef struct { double t, x[2], u, p; } Unit;
"""
OSCILLATOR = r"""
static void start(Unit *m) { m->x[0] = 2.0; m->x[1] = 0.0; m->p = 1.0; }
static void rates(Unit *m, double *f) {
    f[0] = m->x[1];
    f[1] = m->p * (1.0 - m->x[0] * m->x[0]) * m->x[1] - m->x[0] + m->u;
}
static double output(Unit *m) { return m->x[0] * m->x[1]; }
static double indicator(Unit *m) { return 1.0; }
static int event(Unit *m) { return 0; }
static double next(Unit *m) { return -1.0; }
static double slope(Unit *m, unsigned of, unsigned by) {
    double a = m->x[0], b = m->x[1];
    if (of == 3) return by == 2 ? 1.0 : 0.0;
    if (of == 4) return by == 1 ? -2.0 * m->p * a * b - 1.0 : by == 2 ? m->p * (1.0 - a * a) : 1.0;
    return by == 1 ? b : by == 2 ? a : 0.0;
}
"""
BALL = r"""
static void start(Unit *m) { m->x[0] = 1.0; m->x[1] = 0.0; m->p = 0.7; }
static void rates(Unit *m, double *f) { f[0] = m->x[1]; f[1] = -9.81; }
static double output(Unit *m) { return m->x[0]; }
static double indicator(Unit *m) { return m->x[0] <= 0.0 && m->x[1] < 0.0 ? -1.0 : 1.0; }
static int event(Unit *m) {
    if (indicator(m) > 0.0) return 0;
    m->x[1] *= -m->p;
    return 1;
}
static double next(Unit *m) { return -1.0; }
static double slope(Unit *m, unsigned of, unsigned by) { return 0.0; }
"""
CLOCK = r"""
static void start(Unit *m) { m->x[0] = 0.0; m->x[1] = 1.0; m->p = 0.3; }
static void rates(Unit *m, double *f) { f[0] = m->x[1]; f[1] = 0.0; }
static double output(Unit *m) { return m->x[0]; }
static double indicator(Unit *m) { return 1.0; }
static int event(Unit *m) {
    if (m->t < m->p * (1.0 - 1e-12)) return 0;
    m->x[1] += 1.0;
    m->p += 0.3;
    return 1;
}
static double next(Unit *m) { return m->p; }
static double slope(Unit *m, unsigned of, unsigned by) { return 0.0; }
"""
SHARED = r"""
static double *place(Unit *m, unsigned v) {
    return v == 1 ? &m->x[0] : v == 2 ? &m->x[1] : v == 5 ? &m->u : v == 6 ? &m->p : 0;
}
static int read(Unit *m, const unsigned *v, size_t n, double *out) {
    double f[2];
    for (size_t i = 0; i < n; i++) {
        rates(m, f);
        out[i] = v[i] == 0 ? m->t : v[i] == 3 ? f[0] : v[i] == 4 ? f[1] : v[i] == 7 ? output(m) : *place(m, v[i]);
    }
    return 0;
}
static int write_(Unit *m, const unsigned *v, size_t n, const double *in) {
    for (size_t i = 0; i < n; i++) *place(m, v[i]) = in[i];
    return 0;
}
static int derive(Unit *m, const unsigned *z, size_t nz, const unsigned *v, size_t nv, const double *seed,
                  double *out) {
    for (size_t i = 0; i < nz; i++) {
        out[i] = 0.0;
        for (size_t k = 0; k < nv; k++) out[i] += slope(m, z[i], v[k]) * seed[k];
    }
    return 0;
}
int F(SetTime)(Unit *m, double t) { m->t = t; return 0; }
int F(SetContinuousStates)(Unit *m, const double *x, size_t n) { memcpy(m->x, x, n * sizeof *x); return 0; }
int F(GetContinuousStates)(Unit *m, double *x, size_t n) { memcpy(x, m->x, n * sizeof *x); return 0; }
int F(GetNominalsOfContinuousStates)(Unit *m, double *x, size_t n) { x[0] = x[1] = 1.0; return 0; }
int F(GetEventIndicators)(Unit *m, double *z, size_t n) {
    for (size_t i = 0; i < n; i++) z[i] = indicator(m);
    return 0;
}
int F(EnterEventMode)(Unit *m) { return 0; }
int F(EnterContinuousTimeMode)(Unit *m) { return 0; }
int F(ExitInitializationMode)(Unit *m) { return 0; }
int F(Terminate)(Unit *m) { return 0; }
void F(FreeInstance)(Unit *m) { free(m); }
static Unit *made(void) { Unit *m = calloc(1, sizeof *m); start(m); return m; }
"""
OLD = (
    r"""
#define F(name) fmi2##name
"""
    + SHARED
    + r"""
typedef struct { int again, ends, nominals, values, planned; double time; } Info;
void *fmi2Instantiate(const char *a, int b, const char *c, const char *d, const void *e, int f, int g) {
    return made();
}
int fmi2SetupExperiment(Unit *m, int a, double b, double t, int c, double d) { m->t = t; return 0; }
int fmi2EnterInitializationMode(Unit *m) { return 0; }
int fmi2GetReal(Unit *m, const unsigned *v, size_t n, double *out) { return read(m, v, n, out); }
int fmi2SetReal(Unit *m, const unsigned *v, size_t n, const double *in) { return write_(m, v, n, in); }
int fmi2GetDerivatives(Unit *m, double *f, size_t n) { if (m->u > FAILS) return 3; rates(m, f); return 0; }
int fmi2CompletedIntegratorStep(Unit *m, int a, int *event, int *ends) { *event = *ends = 0; return 0; }
int fmi2NewDiscreteStates(Unit *m, Info *i) {
    memset(i, 0, sizeof *i);
    i->values = event(m);
    i->planned = next(m) >= 0.0;
    i->time = next(m);
    return 0;
}
int fmi2GetDirectionalDerivative(Unit *m, const unsigned *z, size_t nz, const unsigned *v, size_t nv, const double *s,
                                 double *out) { return derive(m, z, nz, v, nv, s, out); }
"""
)
NEW = (
    r"""
#define F(name) fmi3##name
"""
    + SHARED
    + r"""
#include <stdbool.h>
void *fmi3InstantiateModelExchange(const char *a, const char *b, const char *c, bool d, bool e, void *f, void *g) {
    return made();
}
int fmi3EnterInitializationMode(Unit *m, bool a, double b, double t, bool c, double d) { m->t = t; return 0; }
int fmi3GetFloat64(Unit *m, const unsigned *v, size_t n, double *out, size_t k) { return read(m, v, n, out); }
int fmi3SetFloat64(Unit *m, const unsigned *v, size_t n, const double *in, size_t k) { return write_(m, v, n, in); }
int fmi3GetContinuousStateDerivatives(Unit *m, double *f, size_t n) {
    if (m->u > FAILS) return 3;
    rates(m, f);
    return 0;
}
int fmi3CompletedIntegratorStep(Unit *m, bool a, bool *event, bool *ends) { *event = *ends = false; return 0; }
int fmi3UpdateDiscreteStates(Unit *m, bool *again, bool *ends, bool *nominals, bool *values, bool *planned, double *t) {
    *again = *ends = *nominals = false;
    *values = event(m);
    *planned = next(m) >= 0.0;
    *t = next(m);
    return 0;
}
int fmi3GetDirectionalDerivative(Unit *m, const unsigned *z, size_t nz, const unsigned *v, size_t nv, const double *s,
                                 size_t ns, double *out, size_t no) { return derive(m, z, nz, v, nv, s, out); }
"""
)
LAWS = {"oscillator": OSCILLATOR, "ball": BALL, "clock": CLOCK}
VARIABLES = (
    ("x0", 1, 'causality="local" variability="continuous" initial="exact" start="0"'),
    ("x1", 2, 'causality="local" variability="continuous" initial="exact" start="0"'),
    ("der(x0)", 3, 'causality="local" variability="continuous" {of} initial="calculated"'),
    ("der(x1)", 4, 'causality="local" variability="continuous" {of} initial="calculated"'),
    ("u", 5, 'causality="input" variability="continuous" start="0"'),
    ("p", 6, 'causality="parameter" variability="fixed" initial="exact" start="1"'),
    ("y", 7, 'causality="output" variability="continuous" initial="calculated"'),
)


def description(name: str, version: int, derivatives: bool) -> str:
    """Return the description of a unit as XML."""
    rows, indicators = [], int(name == "ball")
    for variable, number, text in VARIABLES:
        of = f'derivative="{number - 2}"'
        if version == 2:
            inner = text.format(of="").replace(' start="', "@").split("@")
            start = f' start="{inner[1]}' if len(inner) > 1 else ""
            own = of if "der(" in variable else ""
            rows.append(
                f'<ScalarVariable name="{variable}" valueReference="{number}" {inner[0]}>'
                f"<Real {own}{start}/></ScalarVariable>"
            )
        else:
            rows.append(f'<Float64 name="{variable}" valueReference="{number}" {text.format(of=of)}/>')
    if version == 2:
        structure = (
            '<Outputs><Unknown index="7" dependencies="1 2"/></Outputs><Derivatives><Unknown index="3"/>'
            '<Unknown index="4"/></Derivatives>'
        )
        return (
            f'<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="g" numberOfEventIndicators="{indicators}">'
            f'<ModelExchange modelIdentifier="{name}" providesDirectionalDerivative="{str(derivatives).lower()}"/>'
            f"<ModelVariables>{''.join(rows)}</ModelVariables><ModelStructure>{structure}</ModelStructure>"
            "</fmiModelDescription>"
        )
    # an indicator is a variable in version 3
    rows.append(
        '<Float64 name="z" valueReference="8" causality="local" variability="continuous" initial="calculated"/>'
    )
    rows.append('<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>')
    structure = (
        '<Output valueReference="7" dependencies="1 2"/><ContinuousStateDerivative valueReference="3"/>'
        '<ContinuousStateDerivative valueReference="4"/>' + '<EventIndicator valueReference="8"/>' * indicators
    )
    return (
        f'<fmiModelDescription fmiVersion="3.0" modelName="{name}" instantiationToken="g">'
        f'<ModelExchange modelIdentifier="{name}" providesDirectionalDerivatives="{str(derivatives).lower()}"/>'
        f"<ModelVariables>{''.join(rows)}</ModelVariables><ModelStructure>{structure}</ModelStructure>"
        "</fmiModelDescription>"
    )


def build(folder: Path, name: str, version: int = 3, derivatives: bool = True) -> Path:
    """Compile a unit in a folder and return its path."""
    import fmpy
    from fmpy.fmi2 import FMU2Model
    from fmpy.fmi3 import FMU3Model

    kind, prefix = {2: (FMU2Model, "fmi2"), 3: (FMU3Model, "fmi3")}[version]
    text = "#define FAILS 100.0\n" + COMMON + LAWS[name] + {2: OLD, 3: NEW}[version]
    has = text.replace("F(", prefix)
    # every other function of the interface exists, and fails
    text += "".join(f"int {n}(void) {{ return 3; }}\n" for n in dir(kind) if n.startswith(prefix) and n not in has)
    folder.mkdir(parents=True, exist_ok=True)
    source, library = folder / f"{name}.c", folder / f"{name}.so"
    source.write_text(text, encoding="utf-8")
    subprocess.run(["cc", "-shared", "-fPIC", "-w", "-O1", "-o", str(library), str(source), "-lm"], check=True)
    path = folder / f"{name}.fmu"
    with zipfile.ZipFile(path, "w") as unit:
        unit.writestr("modelDescription.xml", description(name, version, derivatives))
        place = fmpy.platform if version == 2 else fmpy.platform_tuple
        unit.write(library, f"binaries/{place}/{name}{fmpy.sharedLibraryExtension}")
    return path


def write_without_library(path: Path, name: str, version: int, content: bytes = b"no library") -> Path:
    """Write a unit whose library is no program, and return its path."""
    import fmpy

    with zipfile.ZipFile(path, "w") as unit:
        unit.writestr("modelDescription.xml", description(name, version, True))
        place = fmpy.platform if version == 2 else fmpy.platform_tuple
        unit.writestr(f"binaries/{place}/{name}{fmpy.sharedLibraryExtension}", content)
    return path
