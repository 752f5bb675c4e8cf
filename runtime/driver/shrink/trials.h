// Makes runs of a row's program in smaller worlds, several at a time, and says which of them fail as the row does.
//
// What is returned does not depend on how many run at a time: candidates count in their order, and those after the first that fails are
// forgotten, even if they have failed too.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/temporary_files.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/driver/shrink/failure.h"
#include "runtime/driver/shrink/small_world.h"
#include "runtime/driver/study/row_run.h"
#include "runtime/driver/study/study_plan.h"

namespace meld::driver {

class Trials {
  public:
    struct Limits {
        std::size_t tries = 0;
        int jobs = 1;
        double seconds = 0;       // Of a run.
        std::int64_t ticks = -1;  // Of a run that has no end of its own; -1: any number.
    };
    // The options are those of the row, without files of events.
    Trials(StudyPlan& plan, RunOptions options, std::size_t program, Failure wanted, Limits limits, bool quiet);
    // Makes a folder for the worlds that are tried.
    Result<void> open();
    ~Trials();
    Trials(const Trials&) = delete;
    Trials& operator=(const Trials&) = delete;

    using Make = std::function<SmallWorld(std::size_t)>;
    // The first of so many candidates that fails as the row does; nothing: none does, or it is over. Errors: the disk is full, or there can
    // be no further process.
    Result<std::optional<std::size_t>> first(std::size_t count, const Make& make);

    // What it is about, for the progress line.
    void about(std::string what) { about_ = std::move(what); }
    std::size_t tries() const { return tries_; }
    // There are no more tries, or somebody has interrupted it.
    bool over() const { return over_; }
    bool interrupted() const { return interrupted_; }
    // The options of the run in a world at this path.
    RunOptions options_for(const SmallWorld& world, const std::string& path) const;

  private:
    struct Running {
        std::size_t number = 0;
        std::uint64_t hash = 0;
        std::string path;
        std::vector<Leftover> leftovers;  // Its folder and what is in it.
        RowRun run;
    };
    struct Outcome {
        bool failed = false;
        std::optional<std::uint64_t> hash = {};  // Of the world, if it was tried for this.
    };
    // Whether it fails, if that is known; otherwise it has been started.
    Result<std::optional<bool>> start(std::size_t number, const SmallWorld& world, std::vector<Running>& running);
    Result<void> wait(std::vector<Running>& running, std::map<std::size_t, Outcome>& known);
    bool fails(const RowResult& result, const std::string& path) const;

    StudyPlan& plan_;
    const RunOptions options_;
    const std::size_t program_;
    const Failure wanted_;
    const Limits limits_;
    std::string folder_;  // Of the worlds.
    Leftover leftover_;
    std::optional<Progress> progress_;
    std::map<std::uint64_t, bool> tried_;  // By a hash of the world: whether it failed.
    std::string about_;
    std::size_t tries_ = 0, started_ = 0;
    bool over_ = false, interrupted_ = false;
};

}  // namespace meld::driver
