#!/usr/bin/env python3
"""A scene of tests/bench/bench_engines.py in MuJoCo, on one thread. Usage: mujoco_scene.py SCENE OUT TICK..."""
import sys
import time

import mujoco
import numpy


def body(index, numbers, friction):
    place, turn = " ".join(map(str, numbers[:3])), " ".join(map(str, numbers[3:7]))
    return (f'<body name="b{index}" pos="{place}" quat="{turn}"><freejoint/>'
            f'<geom type="box" size="0.5 0.5 0.5" mass="1" friction="{friction}"/>')


def main():
    with open(sys.argv[1]) as lines:
        rows = [line.split() for line in lines]
    value = {row[0]: float(row[1]) for row in rows if row[0] in ("step", "gravity", "friction")}
    bodies = [[float(w) for w in row[1:]] for row in rows if row[0] == "body"]
    planes = [[float(w) for w in row[1:]] for row in rows if row[0] == "plane"]
    # The second body of a hinge is a child of the first, so that hinges cannot part.
    child = {}
    for row in rows:
        if row[0] == "hinge":
            child[int(row[1])] = (int(row[2]), numpy.array(row[3:6], float), numpy.array(row[6:9], float))
    inner = {second for second, _, _ in child.values()}
    # The last two are what they are by default.
    sliding = f'{value["friction"]} 0.005 0.0001'
    text = [f'<mujoco><option timestep="{value["step"]}" gravity="0 0 {-value["gravity"]}"/><size memory="4G"/><worldbody>']
    for *normal, offset in planes:
        at, up = " ".join(str(offset * n) for n in normal), " ".join(map(str, normal))
        text.append(f'<geom type="plane" size="0 0 1" pos="{at}" zaxis="{up}" friction="{sliding}"/>')
    for index, numbers in enumerate(bodies):
        if index in inner:
            continue
        text.append(body(index, numbers, sliding))
        if index in child:
            second, anchor, axis = child[index]
            # No body of a hinge is turned at the start.
            at = numpy.array(bodies[second][:3]) - numbers[:3]
            local = anchor - bodies[second][:3]
            text.append(f'<body name="b{second}" pos="{" ".join(map(str, at))}">'
                        f'<joint type="hinge" pos="{" ".join(map(str, local))}" axis="{" ".join(map(str, axis))}"/>'
                        f'<geom type="box" size="0.5 0.5 0.5" mass="1"/></body>')
        text.append("</body>")
    text.append("</worldbody></mujoco>")
    model = mujoco.MjModel.from_xml_string("".join(text))
    data = mujoco.MjData(model)
    ids = numpy.array([mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, f"b{i}") for i in range(len(bodies))])
    for index, numbers in enumerate(bodies):
        if index in inner:
            continue
        at = model.jnt_dofadr[model.body_jntadr[ids[index]]]
        turn = numpy.zeros(9)
        mujoco.mju_quat2Mat(turn, numpy.array(numbers[3:7]))
        data.qvel[at:at + 3] = numbers[7:10]
        data.qvel[at + 3:at + 6] = turn.reshape(3, 3).T @ numbers[10:13]
        if index in child:
            second, _, axis = child[index]
            joint = model.jnt_dofadr[model.body_jntadr[ids[second]]]
            data.qvel[joint] = (numpy.array(bodies[second][10:13]) - numbers[10:13]) @ axis
    mujoco.mj_forward(model, data)
    with open(sys.argv[2], "w") as out:
        out.write(f"rounding 0 inertia 0.16666667 MuJoCo {mujoco.__version__}, up to {model.opt.iterations} of Newton's iterations\n")
        done = 0
        for tick in map(int, sys.argv[3:]):
            before = time.process_time()
            if tick > done:
                mujoco.mj_step(model, data, nstep=tick - done)
            out.write(f"tick {tick} {1e3 * (time.process_time() - before) / max(tick - done, 1)}\n")
            done = tick
            spin = data.cvel[ids, :3]
            velocity = data.cvel[ids, 3:] + numpy.cross(spin, data.xipos[ids] - data.subtree_com[model.body_rootid[ids]])
            numpy.savetxt(out, numpy.hstack([data.xpos[ids], data.xquat[ids], velocity, spin]), "%.9g")
            out.flush()


if __name__ == "__main__":
    main()
