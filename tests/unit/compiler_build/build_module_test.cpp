// build_module: text in, module out, by way of the cache.
#include "compiler/build/build.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <dlfcn.h>
#include <fmt/format.h>
#include <pwd.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "compiler/build/backend/backend.h"
#include "compiler/build/load_backend.h"
#include "runtime/module/abi/module_note.h"
#include "tests/unit/compiler_build/scratch_folder.h"

namespace meld {
namespace {

namespace fs = std::filesystem;

const std::string kSource = R"(
#include <cstdint>
#include "runtime/module/abi/answer.h"
namespace { std::uint64_t table[2] = {kAnswer, sizeof(void*)}; }
extern "C" const void* claymeld_module() { return table; }
)";

BuildOptions options_in(const std::string& folder) {
    return {.cache_dir = folder,
            .headers = {{"runtime/module/abi/answer.h", "#pragma once\nenum { kAnswer = 42 };\n"}},
            .schema_hash = 0xfedcba9876543210,
            .abi_version = 7};
}

std::ptrdiff_t files_in(const std::string& folder) { return std::distance(fs::directory_iterator(folder), fs::directory_iterator()); }

std::uint64_t first_word(const std::string& path) {
    void* handle = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) return 0;
    const auto entry = reinterpret_cast<const void* (*)()>(::dlsym(handle, "claymeld_module"));
    return entry == nullptr ? 0 : *static_cast<const std::uint64_t*>(entry());
}

ModuleNote note_of(const std::string& path) {
    const Result<std::string> file = read_module_file(path);
    return file ? read_module_note(as_bytes(*file)).value_or(ModuleNote{}) : ModuleNote{};
}

TEST(BuildModule, MakesASharedObjectThatRuns) {
    const ScratchFolder cache;
    const Result<std::string> path = build_module(kSource, "good", options_in(cache.path()));
    ASSERT_TRUE(path) << path.error().message();
    EXPECT_EQ(first_word(*path), 42U);
}

// Steps in both halves share a variable, a constant and a function that is inlined; a constructor runs once.
std::string long_source(int steps) {
    std::string text =
        "#include <cstdint>\nnamespace {\nstd::uint64_t table[2];\nstd::uint64_t calls = 0;\n"
        "const std::uint64_t weights[4] = {1, 10, 100, 1000};\n"
        "struct Once { Once() { calls += 1'000'000; } } once;\n"
        "inline std::uint64_t& tally() { static std::uint64_t here = 0; return here; }\n";
    std::string all;
    for (int i = 0; i < steps; ++i) {
        text += fmt::format(
            "// {:-<200}\n[[gnu::noinline]] void step_{}(std::uint64_t n) {{ calls += weights[(n + {}) & 3]; tally() += n; }}\n", "", i, i);
        all += fmt::format("    step_{}({});\n", i, i);
    }
    return text + "}  // namespace\nextern \"C\" const void* claymeld_module() {\n" + all +
           "    table[0] = calls;\n    table[1] = tally();\n    table[0] += 100'000'000 * table[1];\n    return table;\n}\n";
}

TEST(BuildModule, MakesALongTextInTwoHalvesThatAreOneModule) {
    constexpr int kSteps = 200;
    const std::string text = long_source(kSteps);
    ASSERT_GE(text.size(), kLongModule);
    const Result<const Backend*> backend = load_backend();
    ASSERT_TRUE(backend) << backend.error().message();
    for (const int optimisation : {0, 1, 2}) {
        const auto objects = (*backend)->compile_object(text, "long", {}, {.optimisation = optimisation, .target_cpu = "x86-64"});
        ASSERT_TRUE(objects) << objects.error().message();
        EXPECT_EQ(objects->size(), optimisation == 1 ? 2U : 1U) << optimisation;
        const ScratchFolder cache;
        BuildOptions options = options_in(cache.path());
        options.optimisation = optimisation;
        const Result<std::string> path = build_module(text, "long", options);
        ASSERT_TRUE(path) << path.error().message();
        // 2 i modulo 4 is 0 or 2 by turns.
        const std::uint64_t calls = 1'000'000 + kSteps / 2 * (1 + 100), tally = kSteps * (kSteps - 1) / 2;
        EXPECT_EQ(first_word(*path), calls + 100'000'000 * tally) << optimisation;
    }
}

TEST(BuildModule, WritesItsNote) {
    const ScratchFolder cache;
    const ModuleNote note = note_of(build_module(kSource, "noted", options_in(cache.path())).value());
    EXPECT_EQ(note.abi_version, 7U);
    EXPECT_EQ(note.schema_hash, 0xfedcba9876543210U);
    EXPECT_TRUE(host_runs(note.target)) << note.target;
}

TEST(BuildModule, LeavesNothingButTheModuleInTheCache) {
    const ScratchFolder cache;
    ASSERT_TRUE(build_module(kSource, "tidy", options_in(cache.path())));
    EXPECT_EQ(files_in(cache.path()), 1);
}

TEST(BuildModule, DoesNotBuildTheSameTextTwice) {
    const ScratchFolder cache;
    const std::string first = build_module(kSource, "cached", options_in(cache.path())).value();
    struct ::stat before = {};
    ASSERT_EQ(::stat(first.c_str(), &before), 0);
    const std::string second = build_module(kSource, "cached", options_in(cache.path())).value();
    struct ::stat after = {};
    ASSERT_EQ(::stat(second.c_str(), &after), 0);
    EXPECT_EQ(first, second);
    EXPECT_EQ(before.st_ino, after.st_ino);
}

TEST(BuildModule, KeepsWhatDiffersInAnyInputApart) {
    const ScratchFolder cache;
    const BuildOptions base = options_in(cache.path());
    BuildOptions other_abi = base, other_schema = base, other_level = base, other_header = base;
    other_abi.abi_version = 8;
    other_schema.schema_hash = 1;
    other_level.optimisation = 0;
    other_header.headers[0].second += "enum { kMore };\n";
    for (const BuildOptions& options : {base, other_abi, other_schema, other_level, other_header})
        ASSERT_TRUE(build_module(kSource, "apart", options));
    ASSERT_TRUE(build_module(kSource + " ", "apart", base));
    EXPECT_EQ(files_in(cache.path()), 6);
}

TEST(BuildModule, ReplacesADamagedCacheEntry) {
    const ScratchFolder cache;
    const std::string path = build_module(kSource, "damaged", options_in(cache.path())).value();
    fs::resize_file(path, fs::file_size(path) / 2);
    ASSERT_EQ(build_module(kSource, "damaged", options_in(cache.path())).value(), path);
    EXPECT_EQ(note_of(path).abi_version, 7U);
}

TEST(BuildModule, CallsBrokenTextOurBugAndShowsWhatClangSays) {
    const ScratchFolder cache;
    const Result<std::string> path =
        build_module("#line 12 \"gradient.meld\"\nint f() { return undeclared; }\n", "broken", options_in(cache.path()));
    ASSERT_FALSE(path);
    EXPECT_EQ(path.error().code, ExitCode::OurBug);
    EXPECT_THAT(path.error().problem, testing::HasSubstr("gradient.meld:12:18: error: use of undeclared identifier 'undeclared'"));
    EXPECT_EQ(files_in(cache.path()), 0);
}

TEST(BuildModule, SeesNoHeaderOfTheMachine) {
    const ScratchFolder cache;
    for (const char* header : {"<vector>", "<stdio.h>", "\"/etc/hostname\""})
        EXPECT_FALSE(build_module(std::string("#include ") + header + "\n", "hermetic", options_in(cache.path()))) << header;
}

TEST(BuildModule, NamesTheFolderThatCannotBeWritten) {
    const Result<std::string> path = build_module(kSource, "nowhere", options_in("/proc/claymeld"));
    ASSERT_FALSE(path);
    EXPECT_EQ(path.error().code, ExitCode::UsageOrWorld);
    EXPECT_THAT(path.error().message(), testing::HasSubstr("/proc/claymeld"));
}

TEST(BuildModule, SurvivesManyProcessesBuildingTheSameModule) {
    const ScratchFolder cache;
    constexpr int kProcesses = 6;
    for (int i = 0; i < kProcesses; ++i) {
        if (::fork() == 0) {
            const Result<std::string> path = build_module(kSource, "raced", options_in(cache.path()));
            ::_exit(path && first_word(*path) == 42 ? 0 : 1);
        }
    }
    for (int i = 0; i < kProcesses; ++i) {
        int status = -1;
        ASSERT_GT(::wait(&status), 0);
        EXPECT_EQ(status, 0);
    }
    EXPECT_EQ(files_in(cache.path()), 1);
}

TEST(BuildModule, ReportsADiskThatFillsUpAtAnyPoint) {
    for (::rlim_t limit_bytes = 0; limit_bytes < 8000; limit_bytes += 250) {
        const ScratchFolder cache;
        if (::fork() == 0) {
            ::signal(SIGXFSZ, SIG_IGN);
            const ::rlimit limit = {.rlim_cur = limit_bytes, .rlim_max = limit_bytes};
            ::setrlimit(RLIMIT_FSIZE, &limit);
            const Result<std::string> path = build_module(kSource, "full", options_in(cache.path()));
            const bool fine = path ? note_of(*path).abi_version == 7 : path.error().code == ExitCode::LimitHit;
            ::_exit(fine && files_in(cache.path()) == (path ? 1 : 0) ? 0 : 1);
        }
        int status = -1;
        ASSERT_GT(::wait(&status), 0);
        ASSERT_EQ(status, 0) << limit_bytes;
    }
}

void make_file(const fs::path& path, std::size_t size_bytes, std::chrono::hours age) {
    std::ofstream(path) << std::string(size_bytes, 'x');
    fs::last_write_time(path, fs::file_time_type::clock::now() - age);
}

TEST(Evict, RemovesTheOldestBeyondTheNumberOfFiles) {
    const ScratchFolder cache;
    const fs::path folder = cache.path();
    for (int i = 0; i < 6; ++i) make_file(folder / (std::to_string(i) + ".so"), 10, std::chrono::hours(10 - i));
    evict(cache.path(), (folder / "0.so").string(), {.files = 3});
    EXPECT_TRUE(fs::exists(folder / "0.so")) << "the module just built is kept whatever its age";
    EXPECT_FALSE(fs::exists(folder / "1.so"));
    EXPECT_TRUE(fs::exists(folder / "5.so"));
    EXPECT_EQ(files_in(cache.path()), 3);
}

TEST(Evict, RemovesTheOldestBeyondTheSize) {
    const ScratchFolder cache;
    const fs::path folder = cache.path();
    for (int i = 0; i < 4; ++i) make_file(folder / (std::to_string(i) + ".so"), 1000, std::chrono::hours(10 - i));
    evict(cache.path(), "", {.size_bytes = 2500});
    EXPECT_FALSE(fs::exists(folder / "1.so"));
    EXPECT_EQ(files_in(cache.path()), 2);
}

TEST(Evict, RemovesOnlyStaleTemporaryFilesAndNothingForeign) {
    const ScratchFolder cache;
    const fs::path folder = cache.path();
    make_file(folder / "tmp-1-0.o", 1, std::chrono::hours(2));
    make_file(folder / "tmp-2-0.o", 1, std::chrono::hours(0));
    make_file(folder / "notes.txt", 1, std::chrono::hours(1000));
    evict(cache.path(), "", {.files = 0});
    EXPECT_FALSE(fs::exists(folder / "tmp-1-0.o"));
    EXPECT_EQ(files_in(cache.path()), 2);
}

TEST(DefaultCacheDir, FollowsTheEnvironmentInOrder) {
    ::setenv("HOME", "/home/someone", 1);
    ::unsetenv("XDG_CACHE_HOME");
    ::unsetenv("CLAYMELD_CACHE");
    EXPECT_EQ(default_cache_dir(), "/home/someone/.cache/claymeld");
    ::setenv("XDG_CACHE_HOME", "/var/cache/someone", 1);
    EXPECT_EQ(default_cache_dir(), "/var/cache/someone/claymeld");
    ::setenv("CLAYMELD_CACHE", "/scratch", 1);
    EXPECT_EQ(default_cache_dir(), "/scratch");
    ::unsetenv("CLAYMELD_CACHE");
    ::setenv("XDG_CACHE_HOME", "cache", 1);
    EXPECT_EQ(default_cache_dir(), "/home/someone/.cache/claymeld") << "a relative path is another folder everywhere";
}

TEST(DefaultCacheDir, IsThatOfTheUserWithoutAnEnvironment) {
    for (const char* name : {"HOME", "XDG_CACHE_HOME", "CLAYMELD_CACHE"}) ::unsetenv(name);
    const passwd* user = ::getpwuid(::geteuid());
    EXPECT_EQ(default_cache_dir(), user == nullptr ? "" : std::string(user->pw_dir) + "/.cache/claymeld");
}

TEST(MakeCacheDir, MakesAFolderForThisUserAlone) {
    const ScratchFolder scratch;
    ASSERT_TRUE(make_cache_dir(scratch.path() + "/some/where/"));
    EXPECT_EQ(fs::status(scratch.path() + "/some/where").permissions(), fs::perms::owner_all);
    EXPECT_TRUE(make_cache_dir(scratch.path() + "/some/where"));
}

TEST(MakeCacheDir, NeedsAFolder) {
    EXPECT_THAT(make_cache_dir("").error().message(), testing::HasSubstr("CLAYMELD_CACHE"));
    const ScratchFolder scratch;
    make_file(fs::path(scratch.path()) / "file", 1, std::chrono::hours(0));
    EXPECT_THAT(make_cache_dir(scratch.path() + "/file").error().problem, testing::HasSubstr("no folder"));
}

// What others could have put there would run as this user.
TEST(MakeCacheDir, RefusesAFolderThatOthersMayEnter) {
    for (const fs::perms others : {fs::perms::group_write, fs::perms::others_write, fs::perms::group_read, fs::perms::others_exec}) {
        const ScratchFolder scratch;
        fs::permissions(scratch.path(), fs::perms::owner_all | others);
        EXPECT_EQ(make_cache_dir(scratch.path()).error().suggestion, "chmod 700 " + scratch.path());
    }
}

TEST(MakeCacheDir, RefusesAFolderOfAnotherUser) {
    const ScratchFolder scratch;
    // Only root gives folders away; the others find one of root's.
    const bool given_away = ::chown(scratch.path().c_str(), 12345, 12345) == 0;
    const std::string folder = given_away ? scratch.path() : "/usr";
    struct stat status{};
    ASSERT_EQ(::stat(folder.c_str(), &status), 0);
    EXPECT_THAT(make_cache_dir(folder).error().problem, testing::HasSubstr("another user (number " + std::to_string(status.st_uid) + ")"));
    if (given_away) {
        ASSERT_EQ(::chown(scratch.path().c_str(), ::geteuid(), ::getegid()), 0);
    }
}

TEST(MakeCacheDir, RefusesAFolderThatOthersMayReplace) {
    const ScratchFolder scratch;
    fs::permissions(scratch.path(), fs::perms::all);
    EXPECT_THAT(make_cache_dir(scratch.path() + "/cache").error().problem, testing::HasSubstr(scratch.path() + " is open to all"));
    fs::permissions(scratch.path(), fs::perms::all | fs::perms::sticky_bit);
    EXPECT_TRUE(make_cache_dir(scratch.path() + "/cache"));
}

// A module that somebody else could have planted is not looked at.
TEST(BuildModule, UsesNoModuleOfAFolderThatOthersMayEnter) {
    const ScratchFolder cache;
    ASSERT_TRUE(build_module(kSource, "planted", options_in(cache.path())));
    fs::permissions(cache.path(), fs::perms::all);
    EXPECT_FALSE(build_module(kSource, "planted", options_in(cache.path())));
}

TEST(BuildModule, ReplacesWhatIsNoFile) {
    const ScratchFolder cache;
    const std::string path = *build_module(kSource, "replaced", options_in(cache.path()));
    for (const auto make :
         {+[](const char* at) { return ::mkfifo(at, 0600); }, +[](const char* at) { return ::symlink("/dev/zero", at); }}) {
        fs::remove(path);
        ASSERT_EQ(make(path.c_str()), 0);
        EXPECT_EQ(*build_module(kSource, "replaced", options_in(cache.path())), path);
        EXPECT_EQ(first_word(path), 42);
    }
}

TEST(Evict, RemovesTemporaryFilesOfDeadProcesses) {
    const ScratchFolder cache;
    const TemporaryFile mine(cache.path(), ".o");
    ASSERT_TRUE(mine.write("x"));
    const auto die = [&] {
        const TemporaryFile left(cache.path(), ".o");
        ::_exit(left.write("x") ? 0 : 1);
    };
    EXPECT_EXIT(die(), testing::ExitedWithCode(0), "");
    EXPECT_EQ(files_in(cache.path()), 2);
    evict(cache.path(), "", {});
    EXPECT_EQ(files_in(cache.path()), 1);
    EXPECT_TRUE(fs::exists(mine.path()));
}

TEST(TemporaryFile, WritesToNoFileThatIsThere) {
    const ScratchFolder cache;
    const TemporaryFile first(cache.path(), ".o");
    EXPECT_NE(first.path(), TemporaryFile(cache.path(), ".o").path());
    fs::create_symlink(cache.path() + "/elsewhere", first.path());
    EXPECT_FALSE(first.write("text"));
    EXPECT_FALSE(fs::exists(cache.path() + "/elsewhere"));
}

}  // namespace
}  // namespace meld
