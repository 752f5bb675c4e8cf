// What build_module writes, load_module opens.
#include "compiler/build/build.h"
#include "runtime/module/load/module.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/unit/compiler_build/scratch_folder.h"

namespace meld {
namespace {

const std::string kTable = "int table = 42; extern \"C\" const void* claymeld_module() { return &table; }";

TEST(BuiltModule, IsOpenedAndCalled) {
    const ScratchFolder cache;
    const std::string path = build_module(kTable, "loaded", {.cache_dir = cache.path(), .schema_hash = 11, .abi_version = 2}).value();
    const Result<Module> module = load_module(path, 2);
    ASSERT_TRUE(module) << module.error().message();
    EXPECT_EQ(*static_cast<const int*>(module->table()), 42);
    EXPECT_EQ(module->note().schema_hash, 11U);
    EXPECT_EQ(module->path(), path);
}

// Nothing is mapped before the function here; a sanitizer that looks there for what it knows of it would fall.
TEST(BuiltModule, IsCalledAtTheBeginningOfItsCode) {
    const ScratchFolder cache;
    const std::string text = "int table = 42; extern \"C\" [[gnu::aligned(4096)]] const void* claymeld_module() { return &table; }";
    const std::string path = build_module(text, "begins", {.cache_dir = cache.path(), .abi_version = 1}).value();
    const Result<Module> module = load_module(path, 1);
    ASSERT_TRUE(module) << module.error().message();
    EXPECT_EQ(*static_cast<const int*>(module->table()), 42);
}

TEST(BuiltModule, IsRefusedForAnotherAbiBeforeItsConstructorsRun) {
    const ScratchFolder cache;
    const std::string text = "extern \"C\" [[noreturn]] void abort(); struct Bomb { Bomb() { abort(); } } bomb;\n" + kTable;
    const std::string path = build_module(text, "bomb", {.cache_dir = cache.path(), .abi_version = 1}).value();
    EXPECT_EQ(load_module(path, 2).error().code, ExitCode::ModuleRefused);
}

TEST(BuiltModule, IsRefusedWithoutItsEntry) {
    const ScratchFolder cache;
    const std::string missing = build_module("int x;", "missing", {.cache_dir = cache.path(), .abi_version = 1}).value();
    EXPECT_THAT(load_module(missing, 1).error().problem, testing::HasSubstr("no function claymeld_module"));
    const std::string null = build_module("extern \"C\" const void* claymeld_module() { return nullptr; }", "null",
                                          {.cache_dir = cache.path(), .abi_version = 1})
                                 .value();
    EXPECT_THAT(load_module(null, 1).error().problem, testing::HasSubstr("returned nothing"));
}

TEST(BuiltModule, IsRefusedWhenItCallsWhatNobodyProvides) {
    const ScratchFolder cache;
    const std::string path =
        build_module("extern \"C\" int nobody(); extern \"C\" const void* claymeld_module() { return nobody() ? \"\" : nullptr; }",
                     "unresolved", {.cache_dir = cache.path(), .abi_version = 1})
            .value();
    EXPECT_THAT(load_module(path, 1).error().problem, testing::HasSubstr("nobody"));
}

TEST(BuiltModule, IsRefusedWithASingleByteChanged) {
    const ScratchFolder cache;
    const std::string path = build_module(kTable, "changed", {.cache_dir = cache.path(), .abi_version = 1}).value();
    std::string bytes = read_module_file(path).value();
    for (std::size_t place = 0; place < bytes.size(); place += 61) {
        std::string changed = bytes;
        changed[place] = static_cast<char>(changed[place] ^ 0x40);
        ASSERT_FALSE(read_module_note(as_bytes(changed))) << place;
    }
}

}  // namespace
}  // namespace meld
