#!/usr/bin/env python3
"""A scene of tests/bench/bench_engines.py in Bullet, on one thread. Usage: bullet_scene.py SCENE OUT TICK..."""
import math
import sys
import time

import pybullet


def main():
    with open(sys.argv[1]) as lines:
        rows = [line.split() for line in lines]
    value = {row[0]: float(row[1]) for row in rows if row[0] in ("step", "gravity", "friction")}
    bodies = [[float(w) for w in row[1:]] for row in rows if row[0] == "body"]
    hinges = {int(row[1]): (int(row[2]), [float(w) for w in row[3:]]) for row in rows if row[0] == "hinge"}
    inner = {second for second, _ in hinges.values()}
    # Bullet multiplies the friction of both.
    friction = math.sqrt(value["friction"])
    pybullet.connect(pybullet.DIRECT)
    pybullet.setPhysicsEngineParameter(fixedTimeStep=value["step"], numSubSteps=0, deterministicOverlappingPairs=0)
    pybullet.setGravity(0, 0, -value["gravity"])
    cube = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.5] * 3)
    for row in rows:
        if row[0] == "plane":
            *normal, offset = (float(w) for w in row[1:])
            shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=normal)
            plane = pybullet.createMultiBody(0, shape, basePosition=[offset * n for n in normal], useMaximalCoordinates=True)
            pybullet.changeDynamics(plane, -1, lateralFriction=friction)
    made = {}
    for index, n in enumerate(bodies):
        if index in inner:
            continue
        turn = [n[4], n[5], n[6], n[3]]
        if index not in hinges:
            one = pybullet.createMultiBody(1, cube, basePosition=n[:3], baseOrientation=turn, useMaximalCoordinates=True)
            made[index] = (one, -1)
        else:
            # Its joints are those of a multibody, which cannot part; no body is turned at the start.
            second, h = hinges[index]
            anchor = [h[i] - n[i] for i in range(3)]
            one = pybullet.createMultiBody(
                1, cube, basePosition=n[:3], linkMasses=[1], linkCollisionShapeIndices=[cube], linkVisualShapeIndices=[-1],
                linkPositions=[anchor], linkOrientations=[[0, 0, 0, 1]],
                linkInertialFramePositions=[[bodies[second][i] - h[i] for i in range(3)]],
                linkInertialFrameOrientations=[[0, 0, 0, 1]], linkParentIndices=[0], linkJointTypes=[pybullet.JOINT_REVOLUTE],
                linkJointAxis=[h[3:6]])
            made[index], made[second] = (one, -1), (one, 0)
            pybullet.setJointMotorControl2(one, 0, pybullet.VELOCITY_CONTROL, force=0)
            rate = sum((bodies[second][10 + i] - n[10 + i]) * h[3 + i] for i in range(3))
            pybullet.resetJointState(one, 0, 0, rate)
            pybullet.changeDynamics(one, 0, linearDamping=0, angularDamping=0, jointDamping=0)
        pybullet.changeDynamics(one, -1, lateralFriction=friction, linearDamping=0, angularDamping=0,
                                activationState=pybullet.ACTIVATION_STATE_DISABLE_SLEEPING)
        pybullet.resetBaseVelocity(one, n[7:10], n[10:13])
    parameters = pybullet.getPhysicsEngineParameters()
    version = pybullet.getAPIVersion()
    with open(sys.argv[2], "w") as out:
        out.write(f"rounding 0 inertia 0.16666667 Bullet {version}, {parameters['numSolverIterations']} iterations\n")
        done = 0
        for tick in map(int, sys.argv[3:]):
            before = time.process_time()
            for _ in range(done, tick):
                pybullet.stepSimulation()
            out.write(f"tick {tick} {1e3 * (time.process_time() - before) / max(tick - done, 1)}\n")
            done = tick
            for index in range(len(bodies)):
                one, link = made[index]
                if link < 0:
                    (at, turn), (velocity, spin) = pybullet.getBasePositionAndOrientation(one), pybullet.getBaseVelocity(one)
                else:
                    state = pybullet.getLinkState(one, link, computeLinkVelocity=1, computeForwardKinematics=1)
                    at, turn, velocity, spin = state[0], state[1], state[6], state[7]
                numbers = [*at, turn[3], *turn[:3], *velocity, *spin]
                out.write(" ".join(f"{x:.9g}" for x in numbers) + "\n")
            out.flush()


if __name__ == "__main__":
    main()
