// A scene of tests/bench/bench_engines.py in Rapier, on one thread. Usage: rapier_scene [--iterations N] SCENE OUT TICK...
use rapier3d::prelude::*;
use std::fmt::Write;

// On a processor, which is less than has passed on a busy machine.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").expect("this needs Linux with /proc/self/schedstat");
    let nanoseconds: f64 = text.split_whitespace().next().unwrap().parse().unwrap();
    nanoseconds * 1e-9
}

fn main() {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut world = PhysicsWorld::default();
    if arguments[0] == "--iterations" {
        world.integration_parameters.num_solver_iterations = arguments[1].parse().unwrap();
        arguments.drain(..2);
    }
    let text = std::fs::read_to_string(&arguments[0]).expect("the file of the scene");
    let ticks: Vec<usize> = arguments[2..].iter().map(|t| t.parse().unwrap()).collect();
    let mut friction: Real = 0.0;
    let mut bodies: Vec<RigidBodyHandle> = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let what = words.next().unwrap();
        let n: Vec<Real> = words.map(|w| w.parse().unwrap()).collect();
        match what {
            "step" => world.integration_parameters.dt = n[0],
            "gravity" => world.gravity = Vector::new(0.0, 0.0, -n[0]),
            "friction" => friction = n[0],
            "plane" => {
                let normal = Vector::new(n[0], n[1], n[2]);
                let body = world.insert_body(RigidBodyBuilder::fixed().translation(n[3] * normal));
                let shape = SharedShape::halfspace(normal);
                world.insert_collider(ColliderBuilder::new(shape).friction(friction), Some(body));
            }
            "body" => {
                let turn = Rotation::from_xyzw(n[4], n[5], n[6], n[3]);
                let builder = RigidBodyBuilder::dynamic()
                    .pose(Pose::from_parts(Vector::new(n[0], n[1], n[2]), turn))
                    .linvel(Vector::new(n[7], n[8], n[9]))
                    .angvel(Vector::new(n[10], n[11], n[12]))
                    .can_sleep(false);
                let (handle, _) = world.insert(builder, ColliderBuilder::cuboid(0.5, 0.5, 0.5).density(1.0).friction(friction));
                bodies.push(handle);
            }
            "hinge" => {
                let (first, second) = (bodies[n[0] as usize], bodies[n[1] as usize]);
                let (at, axis) = (Vector::new(n[2], n[3], n[4]), Vector::new(n[5], n[6], n[7]));
                let local = |handle: RigidBodyHandle| world.bodies[handle].position().inverse_transform_point(at);
                // The bodies are not turned at the start, so that the axis is the same for both.
                let joint = RevoluteJointBuilder::new(axis)
                    .local_anchor1(local(first))
                    .local_anchor2(local(second))
                    .contacts_enabled(false);
                world.insert_impulse_joint(first, second, joint);
            }
            _ => panic!("{what}"),
        }
    }
    let mut out = format!("rounding 0 inertia 0.16666667 Rapier 0.36.1, {} iterations\n", world.integration_parameters.num_solver_iterations);
    let mut done = 0;
    for tick in ticks {
        let before = cpu_seconds();
        for _ in done..tick {
            world.step();
        }
        writeln!(out, "tick {} {}", tick, 1e3 * (cpu_seconds() - before) / (tick - done).max(1) as f64).unwrap();
        done = tick;
        for handle in &bodies {
            let body = &world.bodies[*handle];
            let (p, q, v, w) = (body.translation(), *body.rotation(), body.linvel(), body.angvel());
            writeln!(out, "{} {} {} {} {} {} {} {} {} {} {} {} {}", p.x, p.y, p.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z)
                .unwrap();
        }
    }
    std::fs::write(&arguments[1], out).expect("the file of the places");
}
