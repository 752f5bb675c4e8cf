// Rules in Ascent, a Datalog that is compiled into Rust, for tests/bench/bench_ascent.py. Usage: tables TASK FILE; the file has two numbers
// a line. Prints the CPU seconds of the rules and how many rows they have derived.
use ascent::ascent;
use ascent::Dual;

ascent! {
    struct Closure;
    relation link(u32, u32);
    relation path(u32, u32);
    path(x, y) <-- link(x, y);
    path(x, z) <-- path(x, y), link(y, z);
}

ascent! {
    struct SameGeneration;
    relation parent(u32, u32);
    relation same(u32, u32);
    same(x, y) <-- parent(x, p), parent(y, p), if x != y;
    same(x, y) <-- parent(x, a), same(a, b), parent(y, b);
}

ascent! {
    struct Components;
    relation link(u32, u32);
    lattice label(u32, Dual<u32>);
    label(x, Dual(*x)) <-- link(x, _);
    label(y, l) <-- label(x, l), link(x, y);
}

// On a processor, which is less than has passed on a busy machine.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").expect("this needs Linux with /proc/self/schedstat");
    let nanoseconds: f64 = text.split_whitespace().next().unwrap().parse().unwrap();
    nanoseconds * 1e-9
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&arguments[2]).expect("the file of the links");
    let pairs: Vec<(u32, u32)> = text
        .lines()
        .map(|line| {
            let mut numbers = line.split_whitespace().map(|n| n.parse().unwrap());
            (numbers.next().unwrap(), numbers.next().unwrap())
        })
        .collect();
    let before = cpu_seconds();
    let rows = match arguments[1].as_str() {
        "closure" => {
            let mut rules = Closure { link: pairs, ..Default::default() };
            rules.run();
            rules.path.len()
        }
        "same" => {
            let mut rules = SameGeneration { parent: pairs, ..Default::default() };
            rules.run();
            rules.same.len()
        }
        "components" => {
            let mut rules = Components { link: pairs, ..Default::default() };
            rules.run();
            rules.label.len()
        }
        other => panic!("no task {other}"),
    };
    println!("{} {}", cpu_seconds() - before, rows);
}
