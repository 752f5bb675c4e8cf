// All runs of a sweep: the product of programs, worlds, parameters and seeds, with a key for each that says whether it has been made.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/ask/facts/program.h"
#include "runtime/base/error.h"
#include "runtime/driver/setup/options.h"
#include "runtime/driver/study/study_file.h"
#include "runtime/driver/study/study_world.h"
#include "runtime/module/load/module.h"

namespace meld::driver {

struct StudyRow {
    std::size_t program = 0;               // Number among those of the study.
    std::string world = {};                // In tables.
    std::string world_path = {};           // Empty: the default world.
    std::vector<std::string> values = {};  // By parameter of the study; empty: it does not concern this row.
    std::vector<std::string> set = {};     // As for --set.
    std::optional<std::uint64_t> seed = {};
    std::size_t module = 0;  // Number among those of the plan.
    // A hash of everything that the run depends on.
    std::string key = {};
};

// A program compiled for a kind of world.
struct StudyModule {
    std::string path;
    Module module;                                          // Stays loaded.
    std::vector<std::optional<inspect::Program>> measures;  // By measure of the study; nothing: a count.
    const ModuleInfo& info() const { return *static_cast<const ModuleInfo*>(module.table()); }
};

class StudyPlan {
  public:
    // Compiles the programs, and makes the worlds in this folder. Errors: mistakes of the study, of its programs and of its worlds; the
    // compiler has printed those of programs.
    static Result<StudyPlan> make(Study study, const std::string& worlds_folder);

    const Study& study() const { return study_; }
    // In the order of tables: programs, worlds, parameters, seeds.
    const std::vector<StudyRow>& rows() const { return rows_; }
    const StudyModule& module_of(const StudyRow& row) const { return modules_[row.module]; }
    // As for `meldsim run`.
    RunOptions options(const StudyRow& row) const;
    // The same as words of a command, with paths from this folder.
    std::vector<std::string> command(const StudyRow& row, const std::string& from) const;
    // A program compiled for another world, by its number. Modules that were returned before may have moved. Errors: it cannot be compiled.
    Result<std::size_t> module_for(std::size_t program, const std::string& world_path);
    const StudyModule& module(std::size_t number) const { return modules_[number]; }

  private:
    Result<void> add_program(std::size_t program);
    Result<void> check_world(const StudyWorld& world, const ComposedWorld& composed) const;
    Result<void> read_questions(StudyModule& module);
    Result<void> check_axes();
    RunOptions base_options(std::size_t program, const std::string& world_path) const;

    Study study_;
    std::string worlds_folder_;
    std::vector<StudyModule> modules_;
    std::map<std::string, std::size_t> module_numbers_;  // By program and by what of the world matters to the compiler.
    std::vector<std::uint64_t> text_hashes_;             // By module: of all its sources.
    std::vector<bool> used_;                             // By parameter: some row depends on it.
    std::uint64_t options_hash_ = 0;
    std::vector<StudyRow> rows_;
};

// The row of this number, as in tables, or whose key begins like this. Errors: there is none.
Result<std::size_t> row_named(const StudyPlan& plan, const std::string& name);

}  // namespace meld::driver
