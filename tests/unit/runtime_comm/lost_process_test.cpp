#include "runtime/comm/launch/lost_process.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <functional>
#include <thread>
#include <utility>

namespace meld::comm {
namespace {

using Sees = LostProcess::Sees;

// Children of this process, which runs the same program; the first stands for mpirun.
class LostProcessTest : public testing::Test {
  protected:
    LostProcessTest() {
        for (pid_t& child : children_) {
            child = fork();
            if (child == 0)
                for (;;) pause();
        }
    }
    ~LostProcessTest() override {
        for (const pid_t child : children_) kill(child, SIGKILL);
        for (const pid_t child : children_) waitpid(child, nullptr, 0);
    }

    // A process of the run takes its place.
    void comes(std::size_t place, int here) {
        places_[place].here.store(here);
        places_[place].process.store(children_[place + 1]);
    }
    // It stays a zombie, as one that mpirun does not wait for.
    void ends(std::size_t place) {
        kill(children_[place + 1], SIGKILL);
        siginfo_t ended;
        waitid(P_PID, static_cast<id_t>(children_[place + 1]), &ended, WEXITED | WNOWAIT);
    }
    // What is seen in the end.
    Sees seen(ProgramFile program) {
        LostProcess losses(places_, children_[0], program,
                           {.gone_s = 0.03, .coming_s = 0.06, .between_looks = std::chrono::milliseconds(5)});
        Sees sees = Sees::Nothing;
        for (int look = 0; look < 40 && sees == Sees::Nothing; ++look) {
            if (look == 3) happens_();
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            sees = losses.look();
        }
        return sees;
    }
    // While it is looked at.
    void happens(std::function<void()> what) { happens_ = std::move(what); }

    std::array<pid_t, 3> children_{};
    std::array<liveness::Place, 2> places_{};
    const ProgramFile mine_ = program_of(getpid()), other_ = {};

  private:
    std::function<void()> happens_ = [] {};
};

TEST_F(LostProcessTest, AreNoneWhileAllAreThere) {
    comes(0, 2);
    comes(1, 2);
    EXPECT_EQ(seen(other_), Sees::Nothing);
}

TEST_F(LostProcessTest, AreProcessesThatAreGone) {
    comes(0, 2);
    comes(1, 2);
    ends(1);
    EXPECT_EQ(seen(other_), Sees::Gone);
}

TEST_F(LostProcessTest, AreNoneWhereAProcessHasLeftBeforeTheOthers) {
    comes(0, 2);
    comes(1, 2);
    places_[1].left.store(true);
    ends(1);
    EXPECT_EQ(seen(other_), Sees::Nothing);
}

TEST_F(LostProcessTest, TellWhenAllHaveLeft) {
    for (const std::size_t place : {0, 1}) {
        comes(place, 2);
        places_[place].left.store(true);
        ends(place);
    }
    EXPECT_EQ(seen(other_), Sees::AllEnded);
}

TEST_F(LostProcessTest, AreNoneOfProcessesOnOtherMachines) {
    comes(0, 1);
    EXPECT_EQ(seen(other_), Sees::Nothing);
    places_[0].left.store(true);
    ends(0);
    EXPECT_EQ(seen(other_), Sees::Nothing);
}

TEST_F(LostProcessTest, AreNoneWhereAllAreOnOtherMachines) { EXPECT_EQ(seen(other_), Sees::Nothing); }

TEST_F(LostProcessTest, AreProcessesThatHaveNotEvenCome) {
    comes(0, 2);
    EXPECT_EQ(seen(other_), Sees::NeverCame);
}

TEST_F(LostProcessTest, AreNoneWhileSomeAreOnTheirWay) {
    comes(0, 2);
    EXPECT_EQ(seen(mine_), Sees::Nothing);
}

TEST_F(LostProcessTest, AreProcessesThatAllEndOnTheirWay) {
    happens([&] {
        for (const std::size_t place : {0, 1}) ends(place);
        kill(children_[0], SIGKILL);
    });
    EXPECT_EQ(seen(mine_), Sees::NeverCame);
}

TEST_F(LostProcessTest, AreNoneWhileMpirunIsStopped) {
    kill(children_[0], SIGSTOP);
    waitpid(children_[0], nullptr, WUNTRACED);
    comes(0, 2);
    comes(1, 2);
    ends(0);
    EXPECT_EQ(seen(other_), Sees::Nothing);
}

}  // namespace
}  // namespace meld::comm
