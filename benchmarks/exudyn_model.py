"""A model of rigid bodies, built in Exudyn from its description here: the peer of `benchmarks/mechanisms.py`.

Mechanisms in the plane x-y are built of the peer's planar bodies and joints (three coordinates per body, two equations
per hinge, none redundant), all others of its spatial bodies. What is not needed by the benchmarks is refused.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

import flexmb as fmb


def turn(body) -> np.ndarray:
    """Return the matrix of a body's orientation (3, 3)."""
    R = body.rotation
    if R is None:
        return np.eye(3)
    return np.asarray(R, float) if np.shape(R) == (3, 3) else Rotation.from_rotvec(R).as_matrix()


class Peer:
    """An Exudyn system with the bodies, joints and forces of a model.

    Parameters
    ----------
    model : Model
    planar : bool
        Build it of planar bodies.
    free : dict of joint name to (6,)
        Which of x, y, z and the rotations about them are forbidden, in the axes of the first marker, for joints of
        which an equation depends on others.
    node : str
        Kind of spatial nodes: "RotationEulerParameters", "RotationRotationVector" (on the Lie group).
    """

    def __init__(self, model: fmb.Model, planar: bool, free=None, node: str = "RotationEulerParameters"):
        import exudyn as exu
        import exudyn.itemInterface as items

        self.exu, self.items, self.model, self.planar, self.node = (
            exu,
            items,
            model,
            planar,
            getattr(exu.NodeType, node),
        )
        self.container = exu.SystemContainer()
        self.system = self.container.AddSystem()
        self.ground = self.system.AddObject(items.ObjectGround())
        self.bodies, self.nodes, self.origins = {}, [], []
        for body in model.bodies[1:]:
            self._body(body)
        for joint in model.joints:
            self._joint(joint, (free or {}).get(joint.name))
        for force in model.forces:
            self._force(force)
        self.system.Assemble()
        self.start = self.system.systemData.GetSystemState(exu.ConfigurationType.Initial)

    def _body(self, body) -> None:
        items, R, c = self.items, turn(body), np.array(body.center_of_mass)
        omega, center = np.array(body.angular_velocity, float), np.array(body.at, float) + R @ c
        velocity = np.array(body.velocity, float) + np.cross(omega, R @ c)
        self.origins.append((R, c))
        if self.planar:
            angle = float(np.arctan2(R[1, 0], R[0, 0]))
            node = self.system.AddNode(
                items.NodeRigidBody2D(
                    referenceCoordinates=[*center[:2], angle], initialVelocities=[*velocity[:2], omega[2]]
                )
            )
            number = self.system.AddObject(
                items.ObjectRigidBody2D(
                    nodeNumber=node, physicsMass=body.mass, physicsInertia=float(np.asarray(body.inertia)[2, 2])
                )
            )
            marker = self.system.AddMarker(items.MarkerBodyMass(bodyNumber=number))
            self.system.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=list(self.model.gravity)))
        else:
            from exudyn.utilities import RigidBodyInertia

            inertia = RigidBodyInertia(mass=body.mass, inertiaTensor=np.asarray(body.inertia, float))
            made = self.system.CreateRigidBody(
                inertia=inertia,
                nodeType=self.node,
                referencePosition=list(center),
                referenceRotationMatrix=R,
                initialVelocity=list(velocity),
                initialAngularVelocity=list(omega),
                gravity=list(self.model.gravity),
                returnDict=True,
            )
            node, number = made["nodeNumber"], made["bodyNumber"]
        self.nodes.append(node)
        self.bodies[body.name] = number

    def _place(self, name: str):
        """Return (body number, place from its centre of mass, axes of the marker in those of the body)."""
        body, marker = (self.model.body(name.split(".")[0]), name.split(".")[1])
        pose = body.marker_poses()[marker]
        if body.name == "ground":
            return self.ground, np.array(pose.at, float), pose.matrix
        return self.bodies[body.name], np.array(pose.at, float) - np.array(body.center_of_mass), pose.matrix

    def _joint(self, joint, axes) -> None:
        items, places = self.items, [self._place(name) for name in joint.markers]
        kind = "position" if self.planar or isinstance(joint, fmb.Spherical) else "rigid"
        make = items.MarkerBodyPosition if kind == "position" else items.MarkerBodyRigid
        markers = [self.system.AddMarker(make(bodyNumber=number, localPosition=list(at))) for number, at, _ in places]
        if self.planar:
            self.system.AddObject(items.ObjectJointRevolute2D(markerNumbers=markers))
        elif isinstance(joint, fmb.Spherical):
            self.system.AddObject(items.ObjectJointSpherical(markerNumbers=markers))
        else:
            self.system.AddObject(
                items.ObjectJointGeneric(
                    markerNumbers=markers,
                    constrainedAxes=axes or [1, 1, 1, 1, 1, 0],
                    rotationMarker0=places[0][2],
                    rotationMarker1=places[1][2],
                )
            )

    def _force(self, force) -> None:
        items = self.items
        if isinstance(force, fmb.SpringDamper):
            markers = [
                self.system.AddMarker(items.MarkerBodyPosition(bodyNumber=number, localPosition=list(at)))
                for number, at, _ in map(self._place, force.markers)
            ]
            self.system.AddObject(
                items.ObjectConnectorSpringDamper(
                    markerNumbers=markers, stiffness=force.stiffness, referenceLength=force.length
                )
            )
        else:
            number, at, _ = self._place(force.marker)
            marker = self.system.AddMarker(items.MarkerBodyRigid(bodyNumber=number, localPosition=list(at)))
            moment = [float(getattr(x, "value", x)) for x in force.moment]
            self.system.AddLoad(items.LoadTorqueVector(markerNumber=marker, loadVector=moment))

    def positions(self) -> np.ndarray:
        """Return where the origins of the bodies are (n, 3)."""
        kinds, out = self.exu.OutputVariableType, []
        for node, (R0, c) in zip(self.nodes, self.origins, strict=True):
            center = np.array(self.system.GetNodeOutput(node, kinds.Position))
            if self.planar:
                angle = float(np.ravel(self.system.GetNodeOutput(node, kinds.Coordinates))[2]) + np.arctan2(
                    R0[1, 0], R0[0, 0]
                )
                R = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
            else:
                R = np.array(self.system.GetNodeOutput(node, kinds.RotationMatrix)).reshape(3, 3)
            out.append(center - R @ c)
        return np.array(out)

    def run(self, t_end: float, steps: int, modified: bool, dense: bool) -> float:
        """Integrate by generalized-alpha with fixed steps and return the CPU seconds of the solver (nan if
        it fails).
        """
        import time

        exu = self.exu
        settings = exu.SimulationSettings()
        integration = settings.timeIntegration
        integration.numberOfSteps, integration.endTime = steps, t_end
        integration.generalizedAlpha.spectralRadius = 0.8
        integration.newton.useModifiedNewton = modified
        integration.verboseMode = 0
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = 10.0 * t_end
        settings.solutionSettings.solutionInformation = ""
        settings.parallel.numberOfThreads = 1
        settings.displayComputationTime = False
        settings.linearSolverType = exu.LinearSolverType.EXUdense if dense else exu.LinearSolverType.EigenSparse
        self.system.systemData.SetSystemState(self.start)
        began = time.process_time()
        try:
            self.system.SolveDynamic(settings)
        except Exception:
            return float("nan")
        return time.process_time() - began
