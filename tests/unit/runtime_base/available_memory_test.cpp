#include "runtime/base/process/available_memory.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace meld {
namespace {

// A machine with 1,000 kB to give, and files of cgroups as a test writes them.
class AvailableMemoryTest : public ::testing::Test {
  protected:
    AvailableMemoryTest() {
        root_ = std::filesystem::path(::testing::TempDir()) / ::testing::UnitTest::GetInstance()->current_test_info()->name();
        std::filesystem::remove_all(root_);
        write("proc/meminfo", "MemTotal:        4000 kB\nMemAvailable:    1000 kB\n");
    }
    void write(const std::string& path, const std::string& text) const {
        std::filesystem::create_directories((root_ / path).parent_path());
        std::ofstream(root_ / path) << text;
    }
    AvailableMemory available() const { return available_memory(root_.string()); }

  private:
    std::filesystem::path root_;
};

TEST_F(AvailableMemoryTest, IsWhatTheMachineHas) {
    EXPECT_EQ(available().bytes, 1'024'000u);
    EXPECT_EQ(available().by, "the machine");
}

TEST_F(AvailableMemoryTest, IsLimitedByTheGroupsAroundTheProcess) {
    write("proc/self/cgroup", "0::/job/step\n");
    write("sys/fs/cgroup/job/step/memory.max", "max\n");
    write("sys/fs/cgroup/job/step/memory.current", "5000\n");
    EXPECT_EQ(available().bytes, 1'024'000u);
    write("sys/fs/cgroup/job/memory.max", "100000\n");
    write("sys/fs/cgroup/job/memory.current", "40000\n");
    EXPECT_EQ(available().bytes, 60'000u);
    write("sys/fs/cgroup/job/memory.stat", "anon 10000\ninactive_file 30000\n");
    EXPECT_EQ(available().bytes, 90'000u);
    EXPECT_EQ(available().by, "the cgroup");
}

TEST_F(AvailableMemoryTest, IsLimitedByGroupsOfVersionOne) {
    write("proc/self/cgroup", "12:cpu,cpuacct:/job\n9:memory:/job\n");
    write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
    write("sys/fs/cgroup/memory/memory.usage_in_bytes", "70000\n");
    write("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "50000\n");
    write("sys/fs/cgroup/memory/job/memory.usage_in_bytes", "60000\n");
    // More than allowed is in use: nothing is left, which is not the same as not known.
    EXPECT_EQ(available().bytes, 1u);
}

}  // namespace
}  // namespace meld
