// Includes in all their spellings, each file once, found beside the file or in the library.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "parsed.h"

namespace meld::syntax {
namespace {

namespace fs = std::filesystem;

class Include : public testing::Test {
  protected:
    void SetUp() override {
        root_ = fs::temp_directory_path() / ("claymeld_include_test_" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) +
                                             "_" + testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::create_directories(root_ / "inc");
        fs::create_directories(root_ / "library");
    }
    void TearDown() override { fs::remove_all(root_); }

    void write(const std::string& name, const std::string& text) { std::ofstream(root_ / name) << text; }
    Parsed parse_main(const std::string& text) {
        Parsed result;
        const std::uint32_t file = result.files.add((root_ / "main.meld").string(), text);
        result.tree = parse(result.files, file, result.report, {{(root_ / "library").string()}});
        return result;
    }
    fs::path root_;
};

TEST_F(Include, KnowsEverySpelling) {
    write("inc/color.meld", "c(A).");
    write("library/gossip.meld", "g(A).");
    for (const char* line :
         {"include \"inc/color.meld\".", "include \"inc/color.meld\"", "include #inc/color.meld", "#include \"inc/color.meld\"",
          "#include <inc/color.meld>", "include #inc/color.meld.", "use \"inc/color\"."}) {
        const Parsed program = parse_main(std::string("a(A).\n") + line + "\nz(A).\n");
        EXPECT_EQ(program.rendered(), "") << line;
        EXPECT_EQ(print(program.tree), "a(A).\nc(A).\nz(A).\n") << line;
    }
    EXPECT_EQ(print(parse_main("use \"gossip\". #include <gossip.meld>").tree), "g(A).\n");
}

TEST_F(Include, ReadsEachFileOnce) {
    write("a.meld", "include \"b.meld\". a(A).");
    write("b.meld", "include \"a.meld\". include \"./inc/../b.meld\". include \"main.meld\". b(A).");
    write("main.meld", "m(A).");
    const Parsed program = parse_main("include \"a.meld\". include \"b.meld\".");
    EXPECT_EQ(program.rendered(), "");
    EXPECT_EQ(print(program.tree), "b(A).\na(A).\n");
}

TEST_F(Include, TakesTheFilesThatAreMeantAndSearchesNone) {
    write("x.meld", "wrong(A).");
    Parsed program;
    const std::uint32_t main = program.files.add((root_ / "main.meld").string(), "include \"x.meld\". use \"x\". use \"x\".");
    const std::uint32_t other = program.files.add("elsewhere.meld", "e(A).");
    program.tree = parse(program.files, main, program.report, {.libraries = {{"x", "l(A)."}}, .meant = {{other, std::nullopt, main}}});
    EXPECT_EQ(program.rendered(), "");
    EXPECT_EQ(print(program.tree), "e(A).\nl(A).\n");
    EXPECT_EQ(program.tree.includes.size(), 3);
    EXPECT_EQ(program.tree.includes.front().file, other);
}

TEST_F(Include, LooksBesideTheIncludingFile) {
    write("inc/a.meld", "include \"b.meld\".");
    write("inc/b.meld", "b(A).");
    EXPECT_EQ(print(parse_main("include \"inc/a.meld\".").tree), "b(A).\n");
}

TEST_F(Include, SaysWhereItLooked) {
    const Parsed program = parse_main("include \"none.meld\".\ninclude \"inc\".\nuse \"\".\np(A).");
    const auto messages = program.messages();
    ASSERT_EQ(messages.size(), 3u) << program.rendered();
    EXPECT_EQ(messages[0].kind, diagnostics::Kind::IncludeFailed);
    EXPECT_NE(messages[0].help.find("library/none.meld"), std::string::npos);
    EXPECT_NE(messages[1].message.find("is a folder"), std::string::npos);
    EXPECT_EQ(print(program.tree), "p(A).\n");
}

TEST_F(Include, ReportsMistakesInTheIncludedFile) {
    write("a.meld", "p(A) :- q(A.\nr(A).");
    const Parsed program = parse_main("include \"a.meld\".\ns(A).");
    ASSERT_EQ(program.messages().size(), 1u);
    EXPECT_EQ(program.files.file(program.messages()[0].span).path(), (root_ / "a.meld").string());
    EXPECT_EQ(print(program.tree), "r(A).\ns(A).\n");
}

TEST_F(Include, TakesFilesOfTheSetBeforeTheDisk) {
    Parsed program;
    program.files.add("lib.meld", "l(A).");
    program.tree = parse(program.files, program.files.add("main.meld", "include \"lib.meld\"."), program.report);
    EXPECT_EQ(print(program.tree), "l(A).\n");
}

TEST_F(Include, EndsAChainThatIsTooLong) {
    for (int i = 0; i < 300; ++i) write(fmt::format("f{}.meld", i), fmt::format("include \"f{}.meld\".", i + 1));
    const Parsed program = parse_main("include \"f0.meld\".");
    ASSERT_EQ(program.messages().size(), 1u);
    EXPECT_NE(program.messages()[0].message.find("nested"), std::string::npos);
}

}  // namespace
}  // namespace meld::syntax
