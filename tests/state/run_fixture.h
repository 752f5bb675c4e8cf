// What tests of states run: an example or a program of tests/state, with its world.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "runtime/driver/run/run.h"
#include "runtime/module/load/module.h"
#include "runtime/sim/simulation.h"
#include "runtime/world/ensemble/target.h"
#include "runtime/world/file/world_file.h"

namespace meld {

struct Program {
    std::string name;
    std::int64_t ticks = 60;
    std::string component = {};  // An interface that the world chooses another implementation for, and which.
    std::string implementation = {};
    std::string program = {};  // If it has another name than its world.
    std::string engine = {};   // Of the physics, if it is not the one of the world.
    std::string solver = {};
};

inline std::ostream& operator<<(std::ostream& out, const Program& p) { return out << p.name << p.implementation << p.engine << p.solver; }

class ProgramTest : public testing::TestWithParam<Program> {
  protected:
    void SetUp() override {
        const std::string file = (GetParam().name.find('/') == std::string::npos ? CLAYMELD_EXAMPLES "/" : "") + GetParam().name;
        const std::string program = GetParam().program.empty() ? file : GetParam().program;
        Result<world::World> world = world::read_world(file + ".toml");
        ASSERT_TRUE(world.has_value()) << world.error().message();
        world_ = std::move(*world);
        if (!GetParam().component.empty()) world_.components[GetParam().component] = GetParam().implementation;
        if (!GetParam().engine.empty()) world_.physics.engine = GetParam().engine;
        if (!GetParam().solver.empty()) world_.physics.solver = GetParam().solver;
        const Result<std::string> path = driver::compile_program({.program = program + ".meld", .by_links = world_.by_links});
        ASSERT_TRUE(path.has_value()) << path.error().message();
        Result<Module> module = load_module(*path, kAbiVersion);
        ASSERT_TRUE(module.has_value()) << module.error().message();
        module_ = std::make_unique<Module>(std::move(*module));
        Result<world::Target> target = world::Target::make(world_, world::Lattice(world_.lattice));
        ASSERT_TRUE(target.has_value()) << target.error().message();
        target_ = std::make_unique<world::Target>(std::move(*target));
    }

    world::World world_;
    std::unique_ptr<Module> module_;
    std::unique_ptr<world::Target> target_;
};

inline const std::string kOwn = CLAYMELD_STATE_TESTS "/programs/";
// For other worlds than its own: late, lost and web.
inline const std::string kGradient = CLAYMELD_EXAMPLES "/gradient";
// All senses and actions of bodies.
inline const std::string kCrowd = CLAYMELD_STATE_TESTS "/../programs/bodies/crowd";

inline std::string program_name(const testing::TestParamInfo<Program>& program) {
    const std::string& name = program.param.name;
    const Program& p = program.param;
    return name.substr(name.rfind('/') + 1) + p.implementation + p.engine + p.solver;
}

}  // namespace meld
