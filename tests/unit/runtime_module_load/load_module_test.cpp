// load_module on the programs that must not run, and read_module_note on every kind of damage.
#include "runtime/module/load/module.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <elf.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "tests/unit/runtime_module_load/tiny_module.h"

namespace meld {
namespace {

using testing::HasSubstr;

class LoadModule : public testing::Test {
  protected:
    LoadModule() { std::filesystem::create_directories(folder_); }
    ~LoadModule() override { std::filesystem::remove_all(folder_); }

    std::string write(const std::string& bytes) const {
        const std::string path = folder_ + "/module.so";
        std::ofstream(path, std::ios::binary) << bytes;
        return path;
    }

  private:
    std::string folder_ = testing::TempDir() + "claymeld-load-" + std::to_string(::getpid());
};

Result<ModuleNote> read(const std::string& bytes) { return read_module_note(as_bytes(bytes)); }

TEST(ReadModuleNote, FindsWhatTheModuleWasBuiltFor) {
    const Result<ModuleNote> note = read(tiny_module({.abi_version = 3, .schema_hash = 99, .target = "x86-64"}));
    ASSERT_TRUE(note) << note.error().message();
    EXPECT_EQ(note->abi_version, 3U);
    EXPECT_EQ(note->schema_hash, 99U);
    EXPECT_EQ(note->target, "x86-64");
}

TEST(ReadModuleNote, ReadsATargetThatFillsItsField) {
    EXPECT_EQ(read(tiny_module({.target = "sixteen-letters!"})).value().target, "sixteen-letters!");
}

TEST(ReadModuleNote, RefusesAFileCutAtAnyByte) {
    const std::string whole = tiny_module({});
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const Result<ModuleNote> note = read(whole.substr(0, size));
        ASSERT_FALSE(note) << size;
        ASSERT_EQ(note.error().code, ExitCode::ModuleRefused) << size;
    }
}

TEST(ReadModuleNote, RefusesAFileWithAnyBitFlipped) {
    const std::string whole = tiny_module({});
    for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
        std::string damaged = whole;
        damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
        ASSERT_FALSE(read(damaged)) << bit;
    }
}

TEST(ReadModuleNote, SurvivesRandomNumbersInItsTables) {
    const std::string whole = tiny_module({});
    std::mt19937_64 random(1);
    for (int round = 0; round < 100'000; ++round) {
        std::string damaged = whole;
        for (int word = 0; word < 4; ++word) {
            // Huge, zero, small and any: the kinds of number that break a bounds check.
            const std::uint64_t choices[] = {~std::uint64_t{0} - random() % 128, 0, random() % 1024, random()};
            const std::uint64_t value = choices[random() % 4];
            std::memcpy(damaged.data() + random() % (damaged.size() - 8), &value, 1 + random() % 8);
        }
        ASSERT_TRUE(damaged == whole || !read(damaged));
    }
}

TEST(ReadModuleNote, SurvivesASectionThatWrapsAroundTheAddressSpace) {
    std::string hostile = tiny_module({});
    const std::uint64_t huge = ~std::uint64_t{0} - 16;
    std::memcpy(hostile.data() + offsetof(Elf64_Ehdr, e_shoff), &huge, sizeof huge);
    EXPECT_THAT(read(hostile).error().problem, HasSubstr("damaged"));
}

TEST(SealModule, RefusesWhatHasNoNote) {
    std::string text = "#!/bin/sh\n";
    EXPECT_FALSE(seal_module(std::as_writable_bytes(std::span(text))));
}

TEST_F(LoadModule, RefusesAnotherAbi) {
    const std::string path = write(tiny_module({.abi_version = 1}));
    const Error error = load_module(path, 2).error();
    EXPECT_EQ(error.code, ExitCode::ModuleRefused);
    EXPECT_EQ(error.message(), path + ": built for ABI 1, this is ABI 2. Recompile it: meldc compile PROGRAM.meld");
}

TEST_F(LoadModule, RefusesAProcessorThisMachineIsNot) {
    const Error error = load_module(write(tiny_module({.abi_version = 1, .target = "x86-64-v9"})), 1).error();
    EXPECT_EQ(error.code, ExitCode::ModuleRefused);
    EXPECT_THAT(error.problem, HasSubstr("x86-64-v9"));
}

TEST_F(LoadModule, RefusesWhatTheSystemCannotOpen) {
    const Error error = load_module(write(tiny_module({.abi_version = 1})), 1).error();
    EXPECT_EQ(error.code, ExitCode::ModuleRefused);
    EXPECT_THAT(error.problem, HasSubstr("cannot be opened"));
}

TEST_F(LoadModule, RefusesOtherFiles) {
    for (const std::string bytes : {"",
                                    "\x7f"
                                    "ELF",
                                    "route(X) :- link(X).\n"})
        EXPECT_EQ(load_module(write(bytes), 1).error().code, ExitCode::ModuleRefused);
    EXPECT_EQ(load_module("/proc/self/exe", 1).error().code, ExitCode::ModuleRefused);
}

TEST_F(LoadModule, NamesAFileThatIsNotThere) {
    const Error error = load_module("/nowhere/gradient.so", 1).error();
    EXPECT_EQ(error.code, ExitCode::UsageOrWorld);
    EXPECT_THAT(error.problem, HasSubstr("/nowhere/gradient.so"));
    EXPECT_EQ(load_module("/", 1).error().code, ExitCode::UsageOrWorld);
}

}  // namespace
}  // namespace meld
