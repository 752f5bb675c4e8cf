// Rules in Ascent, a Datalog that is compiled into Rust, for tests/bench/bench_ascent.py. Usage: tables TASK FILE; each line of the file has
// the name of a relation and its numbers. Prints the CPU seconds of the rules and how many rows they have derived.
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

ascent! {
    struct PointsTo;
    relation new(u32, u32);
    relation assign(u32, u32);
    relation load(u32, u32, u32);
    relation store(u32, u32, u32);
    relation points(u32, u32);
    relation field(u32, u32, u32);
    points(v, o) <-- new(v, o);
    points(v, o) <-- points(w, o), assign(v, w);
    field(o, f, p) <-- store(v, f, w), points(v, o), points(w, p);
    points(v, p) <-- load(v, w, f), points(w, o), field(o, f, p);
}

// On a processor, which is less than has passed on a busy machine.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/schedstat").expect("this needs Linux with /proc/self/schedstat");
    let nanoseconds: f64 = text.split_whitespace().next().unwrap().parse().unwrap();
    nanoseconds * 1e-9
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string(&arguments[2]).expect("the file of the facts");
    let facts: Vec<(&str, Vec<u32>)> = text
        .lines()
        .map(|line| {
            let (name, numbers) = line.split_once(' ').unwrap();
            (name, numbers.split_whitespace().map(|n| n.parse().unwrap()).collect())
        })
        .collect();
    let pairs = |name| facts.iter().filter(|f| f.0 == name).map(|f| (f.1[0], f.1[1])).collect::<Vec<_>>();
    let triples = |name| facts.iter().filter(|f| f.0 == name).map(|f| (f.1[0], f.1[1], f.1[2])).collect::<Vec<_>>();
    let (first, second) = (pairs(if arguments[1] == "same" { "parent" } else { "link" }), (triples("load"), triples("store")));
    let (new, assign) = (pairs("new"), pairs("assign"));
    let before = cpu_seconds();
    let rows = match arguments[1].as_str() {
        "closure" => {
            let mut rules = Closure { link: first, ..Default::default() };
            rules.run();
            rules.path.len()
        }
        "same" => {
            let mut rules = SameGeneration { parent: first, ..Default::default() };
            rules.run();
            rules.same.len()
        }
        "components" => {
            let mut rules = Components { link: first, ..Default::default() };
            rules.run();
            rules.label.len()
        }
        "points" => {
            let mut rules = PointsTo { new, assign, load: second.0, store: second.1, ..Default::default() };
            rules.run();
            rules.points.len() + rules.field.len()
        }
        other => panic!("no task {other}"),
    };
    println!("{} {}", cpu_seconds() - before, rows);
}
