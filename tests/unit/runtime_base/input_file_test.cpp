#include "runtime/base/files/input_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace meld {
namespace {

using testing::HasSubstr;

class ReadInput : public testing::Test {
  protected:
    void SetUp() override { ASSERT_NE(::mkdtemp(folder_.data()), nullptr); }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    std::string path(const std::string& name) const { return folder_ + "/" + name; }
    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(path(name), std::ios::binary) << text;
        return path(name);
    }
    static std::string problem(const std::string& path, InputKind kind = InputKind::File) {
        const Result<std::string> read = read_input(path, 1000, kind);
        return read ? "it is read: " + *read : read.error().problem;
    }

  private:
    std::string folder_ = testing::TempDir() + "claymeld-input-XXXXXX";
};

TEST_F(ReadInput, GivesTheWholeFile) {
    EXPECT_EQ(*read_input(write("empty", ""), 0), "");
    const std::string bytes("a\0\xff\n", 4);
    EXPECT_EQ(*read_input(write("bytes", bytes), 4), bytes);
    const std::string large(300'000, 'x');
    EXPECT_EQ(*read_input(write("large", large), 1'000'000), large);
}

TEST_F(ReadInput, ReadsFilesThatSayTheyAreEmpty) { EXPECT_THAT(*read_input("/proc/self/status", 100'000), HasSubstr("Name:")); }

TEST_F(ReadInput, RefusesMoreThanTheLimit) {
    EXPECT_EQ(problem(write("much", std::string(1001, 'x'))), path("much") + " is larger than 1000 B, the most that is read");
    EXPECT_EQ(problem("/proc/self/smaps"), "/proc/self/smaps is larger than 1000 B, the most that is read");
}

TEST_F(ReadInput, NamesWhatIsNotThere) {
    EXPECT_EQ(problem(path("none")), "there is no file " + path("none"));
    EXPECT_EQ(problem(write("file", "") + "/below"), "there is no file " + path("file/below"));
    EXPECT_THAT(problem(std::string("a\0b", 3)), HasSubstr("there is no file a"));
}

TEST_F(ReadInput, RefusesWhatIsNoFile) {
    EXPECT_THAT(problem("/dev/zero"), HasSubstr("/dev/zero is a device, not a file"));
    EXPECT_THAT(problem("/dev/zero", InputKind::FileOrPipe), HasSubstr("is a device"));
    EXPECT_THAT(problem("/"), HasSubstr("is a folder"));
    std::filesystem::create_symlink("/dev/zero", path("link"));
    EXPECT_THAT(problem(path("link")), HasSubstr("is a device"));
}

// Nobody writes to it, so a read that waited would wait for ever.
TEST_F(ReadInput, DoesNotWaitForAPipe) {
    ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
    EXPECT_THAT(problem(path("pipe")), HasSubstr("is a pipe, not a file"));
}

TEST_F(ReadInput, ReadsAPipeWhereOneMayBe) {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    ASSERT_EQ(::write(ends[1], "text", 4), 4);
    ::close(ends[1]);
    EXPECT_EQ(*read_input("/dev/fd/" + std::to_string(ends[0]), 4, InputKind::FileOrPipe), "text");
    ::close(ends[0]);
}

TEST_F(ReadInput, EndsAPipeAtTheLimit) {
    const std::string endless = "yes | head -c 100000000 > '" + path("pipe") + "' &";
    ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
    ASSERT_EQ(std::system(endless.c_str()), 0);
    EXPECT_THAT(problem(path("pipe"), InputKind::FileOrPipe), HasSubstr("is larger than 1000 B"));
}

// While it exists, permissions bind this thread, also root's.
class WithoutPrivileges {
  public:
    WithoutPrivileges() {
        ::syscall(SYS_capget, &header_, before_);
        __user_cap_data_struct now[2] = {before_[0], before_[1]};
        now[0].effective &= ~(1u << CAP_DAC_OVERRIDE | 1u << CAP_DAC_READ_SEARCH);
        ::syscall(SYS_capset, &header_, now);
    }
    ~WithoutPrivileges() { ::syscall(SYS_capset, &header_, before_); }
    WithoutPrivileges(const WithoutPrivileges&) = delete;
    WithoutPrivileges& operator=(const WithoutPrivileges&) = delete;

  private:
    __user_cap_header_struct header_{_LINUX_CAPABILITY_VERSION_3, 0};
    __user_cap_data_struct before_[2] = {};
};

TEST_F(ReadInput, NamesWhatMayNotBeRead) {
    ::chmod(write("secret", "x").c_str(), 0);
    const WithoutPrivileges none;
    EXPECT_EQ(problem(path("secret")), path("secret") + " cannot be read (Permission denied)");
}

}  // namespace
}  // namespace meld
