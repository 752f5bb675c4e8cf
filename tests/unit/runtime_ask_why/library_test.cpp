// Every function of the library can be called by a question, with the result that the kernel gives.
#include "runtime/ask/query/library.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "compiler/check/program/library.h"
#include "runtime/ask/facts/types.h"
#include "runtime/ask/query/scratch_memory.h"
#include "runtime/module/kernel/library.h"

namespace meld::inspect {
namespace {

using check::LibraryType;
using check::Type;

// Some value of each type; lists have two elements, structs of floats are lists of them.
class Sample {
  public:
    Sample() : scratch_(view_) {}

    Value of(const LibraryType& type, bool reals) {
        if (type.variable == 'S' || type.variable == 'R') return list(Value{.real = 0.25}, Value{.real = 0.5});
        if (type.variable == 'N') return reals ? Value{.real = 2.0} : Value{.integer = 2};
        if (type.variable == 'T') return {.integer = 2};
        switch (type.kind) {
            case Type::Kind::Float:
                return {.real = 0.5};
            case Type::Kind::String:
                return {.list = make_text(scratch_, "17", 2)};
            case Type::Kind::Vec3:
                return {.list = make_list(scratch_, Words<3>{{word(1.0), word(2.0), word(2.0)}})};
            case Type::Kind::List:
            case Type::Kind::Set:
            case Type::Kind::Array: {
                const LibraryType& part = type.parts.at(0);
                if (part.kind == Type::Kind::Vec3) return list(of(part, reals), of(part, reals));
                if (part.kind == Type::Kind::Float) return list(Value{.real = 0.25}, Value{.real = 0.5});
                return part.variable == 'N' && reals ? list(Value{.real = 1.0}, Value{.real = 2.0})
                                                     : list(Value{.integer = 1}, Value{.integer = 2});
            }
            default:
                return {.integer = 1};
        }
    }
    Value call(const check::LibraryFunction& f, bool reals) {
        const LibraryCall function = library_call(f.cpp, reals);
        EXPECT_NE(function, nullptr) << f.name << " is missing";
        std::vector<Value> arguments;
        for (const LibraryType& parameter : f.parameters) arguments.push_back(of(parameter, reals));
        const Value result = function == nullptr ? Value{} : function(scratch_, types_.table(), 0, arguments.data());
        EXPECT_TRUE(scratch_.went_well()) << f.name << " has no value";
        return result;
    }
    std::string text(Value v) { return {text_of(v.list), count_of(v.list)}; }

  private:
    Value list(Value a, Value b) { return {.list = make_list(scratch_, Words<2>{{a.catom, b.catom}})}; }

    SubdomainView view_;
    Scratch scratch_;
    Types types_;
};

TEST(Library, HasEveryFunction) {
    Sample sample;
    std::size_t called = 0;
    for (const check::LibraryFunction& f : check::library()) {
        if (f.op != check::Op::Library) continue;
        if (f.random) {
            EXPECT_EQ(library_call(f.cpp, false), nullptr) << f.name << " draws random numbers";
            continue;
        }
        for (const bool reals : {false, true}) sample.call(f, reals);
        ++called;
    }
    EXPECT_GT(called, 90u);
    EXPECT_EQ(library_call("no_such", false), nullptr);
}

TEST(Library, GivesResultsOfTheirTypes) {
    Sample sample;
    const auto result = [&](const char* name, std::size_t arguments, bool reals = false) {
        return sample.call(*check::library_function(name, arguments), reals);
    };
    EXPECT_EQ(result("llength", 1).integer, 2);
    EXPECT_EQ(result("lsum", 1).integer, 3);
    EXPECT_EQ(result("lsum", 1, true).real, 3.0);
    EXPECT_EQ(result("lexists", 2).integer, 1);
    EXPECT_EQ(result("smember", 2).integer, 1);
    EXPECT_EQ(result("norm", 1).real, 3.0);
    EXPECT_EQ(result("str2int", 1).integer, 17);
    EXPECT_EQ(sample.text(result("concat", 2)), "1717");
    EXPECT_EQ(sample.text(result("node2str", 1)), "@1");
    EXPECT_EQ(result("floor", 1).integer, 0);
}

TEST(Scratch, GivesBackWhatAMarkSays) {
    SubdomainView view;
    Scratch scratch(view);
    const Scratch::Mark mark = scratch.mark();
    u8* const first = static_cast<u8*>(meld::scratch(scratch, 100));
    for (int i = 0; i < 100; ++i) meld::scratch(scratch, 100'000);
    scratch.release(mark);
    EXPECT_EQ(meld::scratch(scratch, 100), first);
    // Chunks are used again, and replaced where they are too small.
    std::memset(meld::scratch(scratch, 10'000'000), 1, 10'000'000);
    scratch.release(mark);
    EXPECT_EQ(meld::scratch(scratch, 100), first);
    checked_divide(scratch, 0, i64{1}, i64{0});
    EXPECT_FALSE(scratch.went_well());
    EXPECT_TRUE(scratch.went_well());
    EXPECT_EQ(scratch.failures(), 1u);
    EXPECT_EQ(scratch.first_failure(), Trap::DivisionByZero);
}

TEST(Types, HaveOneNumberEach) {
    Types types;
    const TypeInfo* const table = types.table();
    const u16 list = types.number(Type::list_of(Type::Float)), again = types.number(Type::list_of(Type::Float));
    EXPECT_EQ(list, again);
    EXPECT_NE(list, types.number(Type::list_of(Type::Int)));
    const Type pair{Type::Kind::Struct, {Type::Int, Type::list_of(Type::Float)}}, nested{Type::Kind::Struct, {Type::Int, Type::Float}};
    EXPECT_NE(types.number(pair), types.number(nested));
    EXPECT_EQ(types.number(Type::list_of(Type::Error)), types.number(Type::list_of(Type::Int)));
    EXPECT_EQ(types.table(), table);
    EXPECT_EQ(table[types.number(pair)].parts[1], list);
}

}  // namespace
}  // namespace meld::inspect
