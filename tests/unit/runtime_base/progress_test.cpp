#include "runtime/base/terminal/progress.h"

#include <gtest/gtest.h>

#include <string>

#include "runtime/base/terminal/log.h"

namespace meld {
namespace {

// A screen and a clock that the test moves.
struct Stage {
    std::string written;
    double now = 100;

    ProgressOutput output(bool terminal, int columns = 80) {
        return {.write = [this](std::string_view text) { written += text; },
                .seconds_now = [this] { return now; },
                .terminal = terminal,
                .columns = columns};
    }
    std::string take() { return std::exchange(written, ""); }
};

const std::string kErase = "\r\x1b[K";

TEST(Progress, ReplacesItsLineOnATerminalTenTimesASecond) {
    Stage stage;
    Progress progress(stage.output(true));
    progress.update([] { return "tick 1"; });
    EXPECT_EQ(stage.take(), kErase + "tick 1");
    progress.update([]() -> std::string {
        ADD_FAILURE() << "made too early";
        return "";
    });
    EXPECT_EQ(stage.take(), "");
    stage.now += 0.11;
    progress.update([] { return "tick 9"; });
    EXPECT_EQ(stage.take(), kErase + "tick 9");
}

TEST(Progress, IsAPlainLineEveryTenSecondsElsewhere) {
    Stage stage;
    Progress progress(stage.output(false));
    progress.update([] { return "tick 1"; });
    EXPECT_EQ(stage.take(), "");
    stage.now += 10;
    progress.update([] { return "tick 50"; });
    stage.now += 5;
    progress.update([] { return "tick 60"; });
    clear_progress();
    EXPECT_EQ(stage.take(), "tick 50\n");
}

TEST(Progress, IsCutToTheWidthInCharacters) {
    Stage stage;
    Progress progress(stage.output(true, 6));
    progress.update([] { return "µ23456789"; });
    EXPECT_EQ(stage.take(), kErase + "µ2345");
}

TEST(Progress, GoesAwayOnceBeforeALogLineAndAtTheEnd) {
    Stage stage;
    log::set_output([&](std::string_view line) { stage.written += line; });
    {
        Progress progress(stage.output(true));
        progress.update([] { return "tick 1"; });
        log::warning("{} catoms are lost", 3);
        log::info("go on");
        EXPECT_EQ(stage.take(), kErase + "tick 1" + kErase + "warning: 3 catoms are lost\ngo on\n");
        stage.now += 1;
        progress.update([] { return "tick 2"; });
    }
    EXPECT_EQ(stage.take(), kErase + "tick 2" + kErase);
    log::set_output({});
}

TEST(Log, DropsLinesBelowItsLevel) {
    std::string written;
    log::set_output([&](std::string_view line) { written += line; });
    log::debug("unheard");
    log::set_level(log::Level::Debug);
    log::debug("heard");
    log::set_level(log::Level::Off);
    log::error("unheard");
    log::set_level(log::Level::Info);
    log::set_output({});
    EXPECT_EQ(written, "debug: heard\n");
}

}  // namespace
}  // namespace meld
