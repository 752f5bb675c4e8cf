// A module in pieces: what is compiled again after a change, and what the cache keeps.
#include "compiler/build/pieces.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "compiler/build/build.h"
#include "tests/unit/compiler_build/scratch_folder.h"

namespace meld {
namespace {

namespace fs = std::filesystem;

constexpr int kParts = 40;

// Each part adds its weight by a function of its own; the last one calls them all.
TextInParts text_of(const std::function<int(int)>& weight) {
    TextInParts text;
    text.shared = "#include <cstdint>\ntypedef std::uint64_t u64;\ntemplate <class T> T twice(T x) { return x + x; }\nextern u64 sum;\n";
    std::string entry = "u64 sum = 0;\n", calls;
    for (int i = 0; i < kParts; ++i) {
        text.shared += fmt::format("void add_{}();\n", i);
        constexpr CodePasses kAll[] = {CodePasses::All, CodePasses::Few, CodePasses::Quick, CodePasses::None};
        text.parts.push_back(
            {fmt::format("part {}", i), fmt::format("void add_{}() {{ sum += twice<u64>({}); }}\n", i, weight(i)), kAll[i / 10 % 4]});
        calls += fmt::format("add_{}(); ", i);
    }
    text.parts.push_back({.name = "entry",
                          .text = entry +
                                  "extern \"C\" __attribute__((visibility(\"default\"))) const void* claymeld_module() { sum = 0; " +
                                  calls + "return &sum; }\n",
                          .alone = true});
    return text;
}

std::set<std::string> files_of_kind(const std::string& folder, const std::string& extension) {
    std::set<std::string> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == extension) files.insert(entry.path().filename());
    return files;
}
std::set<std::string> pieces_in(const std::string& folder) { return files_of_kind(folder, kPieceExtension); }

std::uint64_t result_of(const std::string& path) {
    void* handle = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle == nullptr) return 0;
    const auto entry = reinterpret_cast<const void* (*)()>(::dlsym(handle, "claymeld_module"));
    return entry == nullptr ? 0 : *static_cast<const std::uint64_t*>(entry());
}

BuildOptions piece_options(const std::string& folder) {
    return {.cache_dir = folder, .optimisation = 1, .schema_hash = 5, .abi_version = 7};
}

std::uint64_t built(const TextInParts& text, const BuildOptions& options) {
    const Result<std::string> path = build_module(text, "parts", options);
    EXPECT_TRUE(path) << path.error().message();
    return path ? result_of(*path) : 0;
}

constexpr std::uint64_t kSum = 2 * kParts * (kParts - 1) / 2;

TEST(Pieces, AreOneModule) {
    const ScratchFolder cache;
    EXPECT_EQ(built(text_of([](int i) { return i; }), piece_options(cache.path())), kSum);
}

TEST(Pieces, AreAsManyAsTheTextIsLong) {
    TextInParts text = text_of([](int i) { return i; });
    const std::size_t few = divide_in_pieces(text).size();
    EXPECT_GE(few, kParts / (2 * text.parts_of_piece));
    EXPECT_LE(few, kParts / 2);
    text.parts_of_piece = 1;
    EXPECT_EQ(divide_in_pieces(text).size(), text.parts.size());
}

TEST(Pieces, OnlyTheChangedOneIsCompiledAgain) {
    const ScratchFolder cache;
    const BuildOptions options = piece_options(cache.path());
    built(text_of([](int i) { return i; }), options);
    const std::size_t before = pieces_in(cache.path()).size();
    for (int changed : {0, 17, kParts - 1})
        EXPECT_EQ(built(text_of([&](int i) { return i == changed ? 1000 : i; }), options),
                  kSum + 2 * (1000 - static_cast<unsigned>(changed)));
    EXPECT_EQ(pieces_in(cache.path()).size(), before + 3);
}

// A part that comes or goes changes its own piece, and at most divides it or joins it with the next.
TEST(Pieces, OfOtherPartsStayAsTheyAreWhenOneGoes) {
    const TextInParts text = text_of([](int i) { return i; });
    std::set<std::string> all;
    for (const Piece& piece : divide_in_pieces(text)) all.insert(piece.text);
    for (std::size_t gone = 0; gone + 1 < text.parts.size(); ++gone) {
        TextInParts less = text;
        less.parts.erase(less.parts.begin() + static_cast<std::ptrdiff_t>(gone));
        std::size_t fresh = 0;
        for (const Piece& piece : divide_in_pieces(less)) fresh += all.contains(piece.text) ? 0 : 1;
        EXPECT_LE(fresh, 3U) << gone;
    }
}

TEST(Pieces, ADamagedOneIsMadeAnew) {
    const ScratchFolder cache;
    const BuildOptions options = piece_options(cache.path());
    const TextInParts text = text_of([](int i) { return i; });
    built(text, options);
    const std::set<std::string> pieces = pieces_in(cache.path());
    int n = 0;
    for (const std::string& piece : pieces) {
        const std::string path = cache.path() + "/" + piece;
        switch (n++ % 3) {
            case 0:
                fs::resize_file(path, fs::file_size(path) / 2);
                break;
            case 1:
                fs::resize_file(path, 3);
                break;
            default: {
                std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
                file.seekp(static_cast<std::streamoff>(fs::file_size(path) / 2));
                file.put('\x55');
                file.put('\xaa');
            }
        }
    }
    for (const std::string& module : files_of_kind(cache.path(), kModuleExtension)) fs::remove(cache.path() + "/" + module);
    EXPECT_EQ(built(text, options), kSum);
    EXPECT_EQ(pieces_in(cache.path()), pieces);
}

TEST(Pieces, OfOtherOptionsOrDeclarationsAreOthers) {
    const ScratchFolder cache;
    const BuildOptions base = piece_options(cache.path());
    BuildOptions other_level = base, other_header = base;
    other_level.optimisation = 2;
    other_header.headers = {{"more.h", "enum { kMore };\n"}};
    TextInParts text = text_of([](int i) { return i; });
    EXPECT_EQ(built(text, base), kSum);
    const std::size_t each = pieces_in(cache.path()).size();
    EXPECT_EQ(built(text, other_level), kSum);
    EXPECT_EQ(built(text, other_header), kSum);
    text.shared += "enum { kAnother };\n";
    EXPECT_EQ(built(text, base), kSum);
    EXPECT_EQ(pieces_in(cache.path()).size(), 4 * each);
}

TEST(Pieces, OldOnesAreRemoved) {
    const ScratchFolder cache;
    BuildOptions options = piece_options(cache.path());
    options.limits.pieces = 5;
    EXPECT_EQ(built(text_of([](int i) { return i; }), options), kSum);
    EXPECT_EQ(pieces_in(cache.path()).size(), 5U);
    EXPECT_EQ(files_of_kind(cache.path(), kModuleExtension).size(), 1U);
    EXPECT_EQ(built(text_of([](int) { return 1; }), options), 2U * kParts);
    EXPECT_EQ(pieces_in(cache.path()).size(), 5U);
    EXPECT_EQ(files_of_kind(cache.path(), kModuleExtension).size(), 2U);
}

TEST(Pieces, ManyProcessesMayMakeTheSame) {
    const ScratchFolder cache;
    constexpr int kProcesses = 4;
    for (int i = 0; i < kProcesses; ++i)
        if (::fork() == 0) ::_exit(built(text_of([](int k) { return k; }), piece_options(cache.path())) == kSum ? 0 : 1);
    for (int i = 0; i < kProcesses; ++i) {
        int status = -1;
        ::wait(&status);
        EXPECT_EQ(status, 0);
    }
    EXPECT_EQ(files_of_kind(cache.path(), kModuleExtension).size(), 1U);
    for (const fs::directory_entry& entry : fs::directory_iterator(cache.path()))
        EXPECT_THAT(entry.path().filename().string(), testing::Not(testing::StartsWith("tmp-")));
}

TEST(Pieces, SayWhatClangSaysOfABrokenOne) {
    const ScratchFolder cache;
    TextInParts text = text_of([](int i) { return i; });
    text.parts[3].text += "int f() { return undeclared; }\n";
    const Result<std::string> path = build_module(text, "broken", piece_options(cache.path()));
    ASSERT_FALSE(path);
    EXPECT_EQ(path.error().code, ExitCode::OurBug);
    EXPECT_THAT(path.error().problem, testing::HasSubstr("undeclared"));
    text.shared += "broken\n";
    EXPECT_FALSE(build_module(text, "broken", piece_options(cache.path())));
}

}  // namespace
}  // namespace meld
