#include "runtime/comm/launch/launch.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fmt/format.h>
#include <csignal>
#include <cstdlib>

namespace meld::comm {
namespace {

// Runs a shell line as processes and returns what they have printed.
std::string output_of(int processes, const std::string& shell_line) {
    testing::internal::CaptureStdout();
    const int exit_code = launch_mpi(processes, {"sh", "-c", shell_line}).exit_code;
    const std::string output = testing::internal::GetCapturedStdout();
    EXPECT_EQ(exit_code, 0) << output;
    return output;
}

TEST(LaunchMpi, GivesTheOutputOfTheProcessesAsItIs) { EXPECT_EQ(output_of(3, "echo hello"), "hello\nhello\nhello\n"); }

TEST(LaunchMpi, PassesArgumentsWithSpacesAndQuotes) {
    testing::internal::CaptureStdout();
    EXPECT_EQ(launch_mpi(1, {"printf", "%s", "a b'c\"\n$x"}).exit_code, 0);
    EXPECT_EQ(testing::internal::GetCapturedStdout(), "a b'c\"\n$x");
}

TEST(LaunchMpi, ReturnsTheExitCodeOfAProcess) {
    EXPECT_EQ(launch_mpi(2, {"true"}).exit_code, 0);
    EXPECT_EQ(launch_mpi(2, {"sh", "-c", "exit 3"}).exit_code, 3);
    EXPECT_EQ(launch_mpi(2, {"sh", "-c", "test $OMPI_COMM_WORLD_RANK = 0 || exit 4"}).exit_code, 4);
}

TEST(LaunchMpi, TellsAKilledProcessFromACrashedOne) {
    EXPECT_EQ(launch_mpi(2, {"sh", "-c", "kill -KILL $$"}).exit_code, 137);
    EXPECT_EQ(launch_mpi(2, {"sh", "-c", "ulimit -c 0; kill -SEGV $$"}).exit_code, 139);
    EXPECT_NE(describe_launch_failure(137).find("killed"), std::string::npos);
    EXPECT_EQ(describe_launch_failure(139), "a process crashed (signal 11: Segmentation fault)");
    EXPECT_EQ(describe_launch_failure(130), "the processes were interrupted");
    EXPECT_EQ(describe_launch_failure(0), "");
    EXPECT_EQ(describe_launch_failure(4), "");
    EXPECT_EQ(describe_launch_failure(255), "");
}

TEST(LaunchMpi, SaysWhenThePathHasNoMpirun) {
    const std::string path = std::getenv("PATH");
    setenv("PATH", "/nonexistent", 1);
    EXPECT_EQ(launch_mpi(1, {"true"}).exit_code, 127);
    setenv("PATH", path.c_str(), 1);
    EXPECT_NE(describe_launch_failure(127).find("mpirun"), std::string::npos);
}

// Where tests run in the background, an interrupt may be ignored, and launch_mpi() leaves that so.
void heed_interrupts() { std::signal(SIGINT, SIG_DFL); }

TEST(LaunchMpi, GivesTheFirstInterruptToTheProcessesToEndWell) {
    heed_interrupts();
    const std::string line = fmt::format("exec 2>/dev/null; trap 'exit 130' USR1; kill -INT {}; while :; do sleep 0.01; done", getpid());
    EXPECT_EQ(launch_mpi(1, {"sh", "-c", line}).exit_code, 130);
}

TEST(LaunchMpi, EndsTheProcessesAtTheSecondInterrupt) {
    heed_interrupts();
    const std::string line =
        fmt::format("exec 2>/dev/null; trap 'kill -INT {0}' USR1; trap '' TERM; kill -INT {0}; while :; do sleep 0.01; done", getpid());
    EXPECT_NE(launch_mpi(1, {"sh", "-c", line}).exit_code, 0);
}

TEST(LaunchMpi, DoesNotOverrideTheUsersSettings) {
    setenv("OMPI_MCA_btl_vader_single_copy_mechanism", "cma", 1);
    EXPECT_EQ(output_of(1, "echo $OMPI_MCA_btl_vader_single_copy_mechanism"), "cma\n");
    unsetenv("OMPI_MCA_btl_vader_single_copy_mechanism");
    EXPECT_EQ(output_of(1, "echo $OMPI_MCA_btl_vader_single_copy_mechanism"), "none\n");
}

TEST(LaunchMpi, YieldsWhenThereAreMoreProcessesThanCores) {
    const long processes = sysconf(_SC_NPROCESSORS_ONLN) + 1;
    const std::string output = output_of(static_cast<int>(processes), "echo $OMPI_MCA_mpi_yield_when_idle");
    EXPECT_EQ(output.substr(0, 2), "1\n");
}

TEST(LaunchMpi, CanBeNested) {
    setenv("OMPI_COMM_WORLD_SIZE", "7", 1);
    EXPECT_EQ(output_of(2, "echo $OMPI_COMM_WORLD_SIZE"), "2\n2\n");
    unsetenv("OMPI_COMM_WORLD_SIZE");
}

}  // namespace
}  // namespace meld::comm
