#include "runtime/world/file/world_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "runtime/world/description/populate.h"
#include "runtime/world/lattice/move_table.h"
#include "tests/unit/runtime_world/parsed_world.h"

namespace meld::world {
namespace {

const std::string kBody = "[[body]]\nshape = \"box(2, 2, 2)\"\n";

TEST(WorldFile, ReadsEachSection) {
    const World world = world_of(R"toml(
lattice = "fcc"
radius = 0.5e-3
seed = 42
held = 1
[[body]]
shape = "minus(box(20,20,10), cylinder(r=4,h=50))"
[[body]]
cells = [[50, 0, 0], [51, 0, 0]]
[target]
shape = "trumpet(length=200)"
cells = "mass"
[facts]
source = ["cell == (0,0,0)", "id == 7"]
temperature = [{ where = "id < 10", args = ["20.5", 3, 4.0, true, "@12", "warm \"x\"", [[1, 2.5], ["a", "2", "@3"], []]] }, { args = [1] }]
[set]
limit = 12
rate = 0.5
name = "n"
[motion]
kind = "lattice"
capacity = 2
keep_connected = true
[record]
every = 10
predicates = ["dist", "parent"]
[time]
tick = "2.5ms"
[limits]
max_ticks = "2M"
max_list = 7
memory = "16GiB"
[components]
mover = "slide"
)toml");
    EXPECT_EQ(world.lattice, LatticeKind::Fcc);
    EXPECT_EQ(world.radius, 0.5e-3);
    EXPECT_EQ(world.seed, 42u);
    EXPECT_EQ(world.held, 1);
    EXPECT_EQ(world.body.text(), "minus(box(20, 20, 10), cylinder(r=4, h=50))");
    EXPECT_EQ(world.cells, (std::vector<Cell>{{50, 0, 0}, {51, 0, 0}}));
    EXPECT_TRUE(world.target && world.target_is_mass && !world.target_cells);
    ASSERT_EQ(world.facts.size(), 4u);
    EXPECT_EQ(world.facts[0].predicate, "source");
    EXPECT_EQ(world.facts[1].where.text(), "id == 7");
    EXPECT_EQ(world.facts[1].place, "w.toml:14:30");
    EXPECT_EQ(world.facts[2].arguments,
              (std::vector<std::string>{"20.5", "3", "4.0", "true", "@12", "\"warm \\\"x\\\"\"", "[[1, 2.5], [\"a\", \"2\", @3], []]"}));
    EXPECT_TRUE(world.facts[3].where.contains(99, {}, {}));
    EXPECT_EQ(world.set, (std::map<std::string, std::string>{{"limit", "12"}, {"rate", "0.5"}, {"name", "\"n\""}}));
    EXPECT_EQ(world.motion.kind, "lattice");
    EXPECT_EQ(world.motion.capacity, 2);
    EXPECT_TRUE(world.motion.keep_connected);
    EXPECT_EQ(world.record.every, 10);
    EXPECT_EQ(world.record.predicates, (std::vector<std::string>{"dist", "parent"}));
    EXPECT_EQ(world.limits.max_ticks, 2'000'000u);
    EXPECT_EQ(world.limits.max_list, 7u);
    EXPECT_DOUBLE_EQ(world.tick_seconds, 2.5e-3);
    EXPECT_EQ(world.limits.memory_bytes, std::uint64_t{16} << 30);
    EXPECT_EQ(world.components.at("mover"), "slide");
}

TEST(WorldFile, NeedsNothingButABody) {
    const World world = world_of(kBody);
    EXPECT_EQ(world.lattice, LatticeKind::Cubic);
    EXPECT_EQ(count_catoms(world, Lattice(world.lattice)), 8u);
}

TEST(WorldFile, NamesTheNearestKey) {
    EXPECT_EQ(error_of("latice = \"fcc\"\n" + kBody), "w.toml:1:1: there is no key 'latice'. did you mean 'lattice'?");
    EXPECT_EQ(error_of(kBody + "[record]\nevry = 3"), "w.toml:4:1: there is no key 'evry' in [record]. did you mean 'every'?");
    EXPECT_EQ(error_of("[[bodies]]\nshape = \"box(1, 1, 1)\""), "w.toml:1:3: there is no key 'bodies'. did you mean 'body'?");
    EXPECT_EQ(error_of("sead = 3\n" + kBody + "[fact]\np = \"all\""), "w.toml:1:1: there is no key 'sead'. did you mean 'seed'?");
    EXPECT_EQ(error_of("lattice = \"hexa\"\n" + kBody), "w.toml:1:11: there is no lattice 'hexa'. did you mean 'hex'?");
    EXPECT_EQ(error_of("lattice = \"free\"\n" + kBody), "w.toml:1:11: there is no lattice 'free'. one of square, hex, cubic, fcc, graph");
}

TEST(WorldFile, PointsIntoExpressions) {
    EXPECT_EQ(error_of("[[body]]\nshape = \"minus(box(1,1,1), shpere(2))\""),
              "w.toml:2:28: there is no shape 'shpere'. did you mean 'sphere'?");
    EXPECT_EQ(error_of(kBody + "[facts]\nsource = [\"id == 1\", \"idd == 2\"]"),
              "w.toml:4:23: nothing is called 'idd' here. did you mean 'id'?");
    EXPECT_EQ(error_of("[[body]]\nshape = \"\"\"\n\nsphere(\n-2)\"\"\""),
              "w.toml:2:9: column 10 of the text: r = -2 of sphere is not above zero");
}

TEST(WorldFile, ReadsTheMovesOfTheWorld) {
    const std::string square = "lattice = \"square\"\n" + kBody + "[motion]\nkind = \"lattice\"\n";
    EXPECT_EQ(parse_world(square, "w.toml")->motion.moves, nullptr);
    const auto named = parse_world(square + "moves = \"sliding\"\n", "w.toml")->motion.moves;
    ASSERT_NE(named, nullptr);
    EXPECT_EQ(named->name(), "the moves \"sliding\"");
    EXPECT_EQ(named->from({}).size(), 16u);
    const std::string own = "[[motion.move]]\nby = [0, 2]\nfull = [[0, 1, 0]]\nempty = [[1, 1]]\none_empty = [[[1, 0], [-1, 0]]]\n";
    const auto both = parse_world(square + "moves = \"sliding\"\n" + own, "w.toml")->motion.moves;
    ASSERT_NE(both, nullptr);
    EXPECT_EQ(both->name(), "the moves \"sliding\" and those of the world");
    EXPECT_EQ(both->from({}).size(), 24u);
    const auto mine = parse_world(square + own + "symmetries = \"none\"\n", "w.toml")->motion.moves;
    ASSERT_NE(mine, nullptr);
    EXPECT_EQ(mine->name(), "the moves of the world");
    ASSERT_EQ(mine->from({}).size(), 1u);
    const Move expected{
        .by = {0, 2, 0}, .full = {{0, 1, 0}}, .empty = {{0, 2, 0}, {1, 1, 0}}, .one_empty = {{Cell{-1, 0, 0}, Cell{1, 0, 0}}}};
    EXPECT_EQ(mine->from({})[0], expected);
}

TEST(WorldFile, RefusesWrongMoves) {
    const std::string cubic = kBody + "[motion]\nkind = \"lattice\"\n", square = "lattice = \"square\"\n" + cubic;
    const auto own = [&](const std::string& keys) { return error_of(square + "[[motion.move]]\n" + keys); };
    EXPECT_EQ(error_of(cubic + "moves = \"pivotting\"\n"),
              "w.toml:5:9: there are no moves 'pivotting' on the cubic lattice. did you mean 'pivoting'?");
    EXPECT_EQ(error_of(cubic + "moves = \"rolling\"\n"),
              "w.toml:5:9: the moves \"rolling\" are for the hex and the fcc lattices, and this world is cubic. "
              "write moves = \"sliding\" or \"pivoting\" or \"leapfrog\" or \"monkey\"");
    EXPECT_EQ(error_of(kBody + "[motion]\nmoves = \"sliding\"\n"),
              "w.toml:4:9: moves says how catoms on a lattice move, and kind is \"none\". write kind = \"lattice\"");
    EXPECT_EQ(error_of(kBody + "[motion]\nkind = \"bodies\"\nmoves = \"sliding\"\n").substr(0, 46),
              "w.toml:5:1: there is no key 'moves' in [motion");
    EXPECT_EQ(own("full = [[1, 0]]\n"), "w.toml:6:1: a [[motion.move]] does not say where it leads. add by = [1, 0], in cells");
    EXPECT_EQ(own("by = [0, 0]\n"), "w.toml:7:6: a move by no cell is none. write by = [1, 0]");
    EXPECT_EQ(own("by = 1\n"), "w.toml:7:6: [[motion.move]] by is an integer, not a cell [x, y] as the mover sees it");
    EXPECT_EQ(own("by = [1]\n"), "w.toml:7:6: [[motion.move]] by has 1 coordinates. write [x, y]");
    EXPECT_EQ(own("by = [1, 0.5]\n"), "w.toml:7:6: [[motion.move]] by has a coordinate that is no whole number");
    EXPECT_EQ(own("by = [1, 0, 1]\n"), "w.toml:7:6: [[motion.move]] by leaves the plane of a flat lattice. write [x, y]");
    EXPECT_EQ(own("by = [3, 0]\n"),
              "w.toml:7:6: [[motion.move]] by is 3 cells away. moves lead at most 2 cells far in each coordinate, and depend on cells at "
              "most 4 away");
    EXPECT_EQ(own("by = [-9223372036854775808, 0]\n").substr(0, 62), "w.toml:7:6: [[motion.move]] by is 9223372036854775808 cells aw");
    EXPECT_EQ(own("by = [1, 0]\nfull = [[0, 1], [1, 1]]\none_empty = [[[1, 1], [0, 1]]]\n"),
              "w.toml:9:13: one of the cells [1, 1] and [0, 1] would have to be empty, and full has both of them. "
              "take one of the two out of full");
    EXPECT_EQ(own("by = [1, 0]\nfull = [0, 1]\n"),
              "w.toml:8:9: [[motion.move]] full is an integer, not a cell [x, y] as the mover sees it");
    EXPECT_EQ(own("by = [1, 0]\nfull = [[0, 0]]\n"), "w.toml:8:9: [[motion.move]] full has the mover's own cell. take it out");
    EXPECT_EQ(own("by = [1, 0]\nfull = [[0, 1]]\nempty = [[0, 1]]\n"),
              "w.toml:8:8: the cell [0, 1] would have to be both full and empty. take one of the two out");
    EXPECT_EQ(own("by = [1, 0]\nfull = [[1, 0]]\n"),
              "w.toml:8:8: the cell [1, 0] would have to be both full and empty. the mover goes there, so it is empty: take it out");
    EXPECT_EQ(own("by = [1, 0]\none_empty = [[[1, 1]]]\n"),
              "w.toml:8:14: [[motion.move]] one_empty has 1 cells that are no pair. write two cells in brackets of their own");
    EXPECT_EQ(own("by = [1, 0]\nsymmetries = \"some\"\n"),
              "w.toml:8:14: [[motion.move]] symmetries = \"some\" does not exist. one of all, rotations, none");
    EXPECT_EQ(own("by = [1, 0]\nfulls = []\n").substr(0, 55), "w.toml:8:1: there is no key 'fulls' in [[motion.move]].");
    EXPECT_EQ(error_of("lattice = \"hex\"\n" + cubic + "[[motion.move]]\nby = [2, 1]\n").substr(0, 80),
              "w.toml:7:6: rotated or reflected, the move or a cell that it depends on is too f");
}

TEST(WorldFile, RefusesWrongTypesAndRanges) {
    EXPECT_EQ(error_of("radius = \"1\"\n" + kBody), "w.toml:1:10: radius is a string, not a number");
    EXPECT_EQ(error_of("radius = -1\n" + kBody), "w.toml:1:10: radius = -1 is not a number above zero");
    EXPECT_EQ(error_of("radius = nan\n" + kBody), "w.toml:1:10: radius = nan is not a number above zero");
    EXPECT_EQ(error_of("seed = -1\n" + kBody), "w.toml:1:8: seed = -1 is below zero");
    EXPECT_EQ(error_of("seed = 1.5\n" + kBody), "w.toml:1:8: seed is a number, not a whole number, as 2000000 or \"2M\"");
    EXPECT_EQ(error_of("held = 2\n" + kBody), "w.toml:1:8: held = 2 is more than a catom can hold, [motion] capacity = 1");
    EXPECT_EQ(error_of("record = 3\n" + kBody), "w.toml:1:10: record is an integer, not a table [record]");
    EXPECT_EQ(error_of(kBody + "[record]\nevery = 0"), "w.toml:4:9: [record] every = 0 is not between 1 and 2147483647");
    EXPECT_EQ(error_of(kBody + "[record]\npredicates = [1]"), "w.toml:4:15: an item of [record] predicates is an integer, not a string");
    EXPECT_EQ(error_of(kBody + "[motion]\nkeep_connected = 1"), "w.toml:4:18: [motion] keep_connected is an integer, not true or false");
    EXPECT_EQ(error_of(kBody + "[limits]\nmemory = \"16Gx\"").substr(0, 60),
              "w.toml:4:10: [limits] memory: '16Gx' has the unknown suffix ");
    EXPECT_EQ(error_of(kBody + "[facts]\nheat = [{ args = [inf] }]"), "w.toml:4:19: an argument is not a finite number");
    EXPECT_EQ(error_of(kBody + "[facts]\nheat = [{ args = [\"@x\"] }]"),
              "w.toml:4:19: '@x' names no catom. write @ and its number, as in \"@3\"");
    EXPECT_EQ(error_of(kBody + "[facts]\nheat = 3"), "w.toml:4:8: a fact is an integer, not a region or { where = ..., args = [...] }");
    EXPECT_EQ(error_of(kBody + "[facts]\nheat = [{ args = [[1, {}]] }]"),
              "w.toml:4:23: an argument is a table, not a number, a string, an array, true or false");
    EXPECT_EQ(error_of(kBody + "[time]\ntick = \"0s\""), "w.toml:4:8: [time] tick is not above zero");
    EXPECT_EQ(error_of(kBody + "[time]\ntick = -1"), "w.toml:4:8: [time] tick = -1 is not a number above zero");
    EXPECT_EQ(error_of(kBody + "[time]\ntick = \"1 mile\"").substr(0, 63),
              "w.toml:4:8: [time] tick: '1 mile' has the unknown suffix 'mile'");
    EXPECT_EQ(error_of(kBody + "[target]\ncells = 3"),
              "w.toml:3:1: [target] has neither shape nor a list of cells. add cells = [[0, 0, 0]]");
    EXPECT_EQ(error_of(kBody + "[target]\ncells = []"), "w.toml:4:9: [target] cells lists no cell. take [target] out");
    EXPECT_EQ(error_of(kBody + "[target]\nshape = \"box(1,1,1)\"\ncells = [[0,0,0]]"),
              "w.toml:5:9: [target] cells lists the target, so it has no shape. take one of the two out");
    EXPECT_EQ(error_of(kBody + "[target]\ncells = [[0,0,0],[0,0,0]]"),
              "w.toml:4:18: cell (0, 0, 0) is listed twice, first in w.toml:4:10. take one of them out");
    EXPECT_EQ(error_of("ports = \"blinki\"\n" + kBody),
              "w.toml:1:9: there is no robot 'blinki' whose ports are known. did you mean 'blinky'?");
    EXPECT_EQ(
        error_of("ports = \"smartblocks\"\n" + kBody),
        "w.toml:1:9: ports = \"smartblocks\" numbers the sides of SmartBlocks, which stand on the square lattice, and this one is cubic. "
        "write lattice = \"square\", or take ports out");
    EXPECT_EQ(error_of("ports = \"blinky\"\n" + kBody + "[motion]\nkind = \"bodies\"\n"),
              "w.toml:1:9: ports = \"blinky\" numbers the sides of Blinky Blocks, and a port of a body is only the number of a link. "
              "take it out");
    EXPECT_EQ(error_of("ports = \"blinky\"\nlattice = \"graph\"\ngraph = \"ring(5)\"\n"),
              "w.toml:1:9: ports = \"blinky\" numbers the sides of Blinky Blocks, and the nodes of a graph have none. take it out");
    EXPECT_EQ(error_of(kBody + "[target]\nshape = \"sphere(3)\"\nfit = \"mas\""),
              "w.toml:5:7: [target] fit = \"mas\" does not exist. did you mean 'mass'?");
    EXPECT_EQ(error_of(kBody + "[target]\nshape = \"sphere(3)\"\nfit = \"mass\"\ncells = 3"),
              "w.toml:6:9: [target] cells already follows from fit = \"mass\". take one of the two out");
    EXPECT_EQ(error_of("a = = 3").substr(0, 11), "w.toml:1:5:");
}

TEST(WorldFile, ReadsWhenEventsHappen) {
    const World world = world_of(kBody +
                                 "[time]\ntick = \"10ms\"\n[[event]]\ntick = 4\nevery = 3\ntimes = 3\ngive = { tap = \"id == 0\" }\n"
                                 "[[event]]\ntime = \"0.05s\"\n[event.take]\nheat = [{ args = [1] }, { args = [2] }]\n");
    ASSERT_EQ(world.events.size(), 2u);
    std::vector<std::int64_t> ticks;
    for (std::int64_t t = 0; t < 20; ++t)
        if (world.events[0].happens_in(t)) ticks.push_back(t);
    EXPECT_EQ(ticks, (std::vector<std::int64_t>{4, 7, 10}));
    EXPECT_EQ(world.events[0].last(), 10);
    EXPECT_EQ(world.events[0].give.at(0).predicate, "tap");
    EXPECT_EQ(world.events[1].tick, 5);
    EXPECT_EQ(world.events[1].last(), 5);
    EXPECT_EQ(world.events[1].take.size(), 2u);
}

TEST(WorldFile, RefusesEventsThatAreNone) {
    const auto error = [](const std::string& event) { return error_of(kBody + "[[event]]\n" + event); };
    EXPECT_EQ(error("give = { tap = \"all\" }"), "w.toml:3:1: an [[event]] has neither tick nor time. write tick = 10");
    EXPECT_EQ(error("tick = 1\ntime = 1\ngive = { tap = \"all\" }"), "w.toml:3:1: an [[event]] has both tick and time. write tick = 10");
    EXPECT_EQ(error("tick = 1"), "w.toml:3:1: this [[event]] does nothing. write give = { tap = \"id == 0\" }");
    EXPECT_EQ(error("tick = 0\ngive = { tap = \"all\" }"), "w.toml:4:8: [[event]] tick = 0 is not between 1 and 1000000000");
    EXPECT_EQ(error("tick = 1\nevery = 2\ngive = { tap = \"all\" }"),
              "w.toml:3:1: an [[event]] that happens again has both every and times. write every = 10 and times = 3");
    EXPECT_EQ(error("tick = 1\ngive = \"all\""), "w.toml:5:8: give is a string, not a table of facts");
    EXPECT_EQ(error("tick = 1\ntake = { tap = \"idd\" }"), "w.toml:5:17: nothing is called 'idd' here. did you mean 'id'?");
    EXPECT_EQ(error("tick = 1\ngve = { tap = \"all\" }"), "w.toml:5:1: there is no key 'gve' in [[event]]. did you mean 'give'?");
    EXPECT_EQ(error("tick = 1\ntimes = 3000000000\nevery = 1\ngive = { tap = \"all\" }"),
              "w.toml:5:9: [[event]] times = 3000000000 is not between 1 and 1000000000");
    EXPECT_EQ(error_of("event = 3\n" + kBody), "w.toml:1:9: event is an integer, not a table [[event]]");
}

TEST(WorldFile, RefusesWorldsWithoutCatoms) {
    EXPECT_EQ(error_of(""), "w.toml: no catom: the body is empty. add [[body]] shape = \"box(10, 10, 10)\"");
    EXPECT_EQ(error_of("[[body]]\nshape = \"move(sphere(0.1), 0.5, 0.5)\""),
              "w.toml:1:1: no catom: the body is empty. make its shape larger");
    EXPECT_EQ(error_of("[[body]]\nshape = \"minus(box(3,3,3), box(3,3,3))\""),
              "w.toml:1:1: no catom: the body is empty. make its shape larger");
    EXPECT_EQ(error_of("[[body]]\ncells = []"), "w.toml:1:1: no catom: the body is empty. add a [[body]] with a shape or cells");
    EXPECT_EQ(error_of("[[body]]"), "w.toml:1:1: a [[body]] has neither shape nor cells. give each its own [[body]] with one of them");
    EXPECT_EQ(error_of("[[body]]\nshape = \"sphere(r=1e7)\"").substr(0, 31), "w.toml:1:1: the body has up to ");
}

TEST(WorldFile, ChecksListedCells) {
    EXPECT_EQ(error_of("[[body]]\ncells = [[0,0,0], [1,0,0], [0,0,0]]"),
              "w.toml:2:28: cell (0, 0, 0) is listed twice, first in w.toml:2:10. take one of them out");
    EXPECT_EQ(error_of("[[body]]\ncells = [[0,0]]"), "w.toml:2:10: a cell of the cubic lattice has 3 coordinates, here are 2");
    EXPECT_EQ(error_of("lattice = \"hex\"\n[[body]]\ncells = [[0,0], [1,2,3]]"),
              "w.toml:3:17: z = 3 of a cell is not 0, but the hex lattice is flat");
    EXPECT_EQ(error_of("[[body]]\ncells = [[0,0,1.5]]"), "w.toml:2:15: a cell coordinate is a number, not an integer");
    EXPECT_EQ(error_of("[[body]]\ncells = [[0,0,2000000]]"), "w.toml:2:10: cell coordinate 2000000 is not between -1048576 and 1048575");
}

class CellFiles : public testing::Test {
  protected:
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "meld_world_file_test";
    void SetUp() override { std::filesystem::create_directories(folder); }
    void TearDown() override { std::filesystem::remove_all(folder); }
    void write(const std::string& name, const std::string& text) const { std::ofstream(folder / name, std::ios::binary) << text; }
    Result<World> read() const { return read_world((folder / "w.toml").string()); }
};

TEST_F(CellFiles, AreReadRelativeToTheWorldFile) {
    write("w.toml", "[[body]]\ncells = \"points.csv\"\n");
    write("points.csv", "x,y,z\r\n0,0,0\r\n# a comment\n\n 1, -2 ,3\n");
    const Result<World> world = read();
    ASSERT_TRUE(world) << world.error().message();
    EXPECT_EQ(world->cells.size(), 2u);
    EXPECT_EQ(count_catoms(*world, Lattice(world->lattice)), 2u);
}

TEST_F(CellFiles, AreReadWithoutAHeader) {
    write("w.toml", "lattice = \"square\"\n[[body]]\ncells = \"points.csv\"\n");
    write("points.csv", "0,0\n0,1");
    EXPECT_EQ(read()->cells.size(), 2u);
}

TEST_F(CellFiles, SayWhereTheyAreWrong) {
    write("w.toml", "[[body]]\ncells = \"points.csv\"\n");
    const std::string path = (folder / "points.csv").string();
    write("points.csv", "0,0,0\n1,nan,0\n");
    EXPECT_EQ(read().error().message(), path + ":2:3: 'nan' is not a cell coordinate. write whole numbers, x,y,z");
    write("points.csv", "0,0,0\n1,0,0\n0,0,0\n");
    EXPECT_EQ(read().error().problem, path + ":3: cell (0, 0, 0) is listed twice, first in " + path + ":1");
    write("points.csv", "0,0,\n");
    EXPECT_EQ(read().error().problem, path + ":1:5: '' is not a cell coordinate");
    write("points.csv", "0,0,0,0\n");
    EXPECT_EQ(read().error().problem, path + ":1: a cell of the cubic lattice has 3 coordinates, here are 4");
    std::filesystem::remove(path);
    EXPECT_THAT(read().error().problem, testing::EndsWith(":2:9: there is no file " + path));
}

// Each key that names a CSV file, with rows that it takes, in quotes too.
TEST_F(CellFiles, EveryTableOfAWorldHasTheSameQuotes) {
    struct Case {
        const char *key, *world, *rows;
    };
    const std::string lossy = "[[body]]\nshape = \"box(2, 2, 2)\"\n[network]\nkind = \"lossy\"\nlinks = \"table.csv\"\n";
    const Case all[] = {
        {"cells", "[[body]]\ncells = \"table.csv\"\n", "0,0,0\n\"1\", \"0\",0\n"},
        {"[without] cells", "[[body]]\nshape = \"box(2, 2, 2)\"\n[without]\ncells = \"table.csv\"\n", "\"x\",y,z\n\"0\",0,0\n"},
        {"positions", "[[body]]\npositions = \"table.csv\"\n[motion]\nkind = \"bodies\"\n", "x,y,z,\"mass\"\n\"0\",0,0,\"1\"\n"},
        {"links", "lattice = \"graph\"\nlinks = \"table.csv\"\n", "from,\"to\"\na,\"san \"\"f\"\"\"\n\"a\",\"b, c\"\n"},
        {"nodes", "lattice = \"graph\"\nlinks = \"edges.csv\"\nnodes = \"table.csv\"\n", "node,\"level\"\n\"0\",1\n1,\"2\"\n"},
        {"[network] links", lossy.c_str(), "from,to,\"loss\"\n\"0\",1,\"0.5\"\n"},
    };
    const std::pair<const char*, const char*> wrong[] = {
        {"\"0,0,0\n", ":1: this quote is not closed. end the field with a quote on the same line"},
        {"\"0\"1,0,0\n", ":4: text follows the quote that ends a field. write a quote inside a quoted field twice"},
        {"0\"1\",0,0\n", ":2: a quote inside a field that does not begin with one. put the whole field in quotes"},
    };
    write("edges.csv", "0,1\n");
    const std::string path = (folder / "table.csv").string();
    for (const auto& [key, world, rows] : all) {
        write("w.toml", world);
        for (const std::string mark : {"", "\xEF\xBB\xBF"}) {
            write("table.csv", mark + rows);
            EXPECT_TRUE(read().has_value()) << key << ": " << read().error().message();
        }
        const auto line = std::count(rows, rows + std::strlen(rows), '\n') + 1;
        for (const auto& [row, message] : wrong) {
            write("table.csv", std::string(rows) + row);
            const auto world_read = read();
            ASSERT_FALSE(world_read.has_value()) << key << ": " << row;
            EXPECT_THAT(world_read.error().message(), testing::StartsWith(path + ":" + std::to_string(line) + message)) << key;
        }
    }
}

TEST(WorldFile, SaysWhyAFileCannotBeRead) {
    EXPECT_EQ(read_world("/no/such/world.toml").error().problem, "there is no file /no/such/world.toml");
    EXPECT_EQ(read_world("/").error().problem, "/ is a folder, not a file");
}

}  // namespace
}  // namespace meld::world
