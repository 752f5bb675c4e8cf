// Order, hash, blocks, packing and text of values, over random types and values.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <thread>

#include "runtime/engine/tuple/value_text.h"
#include "tests/unit/runtime_engine_tuple/types.h"

namespace meld::tuple {
namespace {

using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t n) { return static_cast<std::size_t>(random() % n); }

// A type at most this deep.
u16 random_type(Types& types, Random& random, int depth) {
    if (depth == 0 || below(random, 3) == 0) {
        static constexpr u16 scalars[] = {Types::kInt, Types::kFloat, Types::kBool, Types::kNode};
        const std::size_t choice = below(random, 6);
        if (choice < 4) return scalars[choice];
        return types.add(choice == 4 ? ValueType::String : ValueType::Vec3);
    }
    static constexpr ValueType kinds[] = {ValueType::List, ValueType::Set, ValueType::Array, ValueType::Struct, ValueType::Tuple};
    const ValueType kind = kinds[below(random, 5)];
    std::vector<u16> parts;
    const std::size_t count = kind >= ValueType::Struct ? 1 + below(random, 3) : 1;
    for (std::size_t i = 0; i < count; ++i) parts.push_back(random_type(types, random, depth - 1));
    return types.add(kind, parts);
}

// A value out of few, so that equal ones are met; some of them odd.
Value random_value(Type type, Random& random, Arena& arena) {
    Value v{};
    switch (type.kind()) {
        case ValueType::Int: {
            static constexpr i64 odd[] = {std::numeric_limits<i64>::min(), std::numeric_limits<i64>::max(), -1, 0, 1, 2};
            v.integer = odd[below(random, 6)];
            return v;
        }
        case ValueType::Float: {
            static constexpr double odd[] = {0.0, -0.0, 1.5, -2e300, 5e-324, 3};
            v.real = odd[below(random, 6)];
            return v;
        }
        case ValueType::Bool:
            v.integer = static_cast<i64>(below(random, 2));
            return v;
        case ValueType::Node:
            v.catom = below(random, 2) ? below(random, 3) : ~u64{0} >> 1;
            return v;
        case ValueType::String: {
            std::string text;
            static constexpr std::string_view pieces[] = {
                "a", "b", "\"", "\\", "\n", "\xc3\xa9", "\xff", "\xe2\x82", std::string_view("\0", 1), " "};
            for (std::size_t n = below(random, 5); n > 0; --n) text += pieces[below(random, 10)];
            v.list = arena.text(text);
            return v;
        }
        default:
            break;
    }
    std::vector<u64> items;
    const std::size_t count = type.has_fields() ? type.field_count() : below(random, 4);
    for (std::size_t i = 0; i < count; ++i) items.push_back(random_value(type.item(i), random, arena).catom);
    if (type.kind() == ValueType::Set) {
        const auto order = [&](u64 a, u64 b) { return compare(type.item(0), std::bit_cast<Value>(a), std::bit_cast<Value>(b)); };
        std::sort(items.begin(), items.end(), [&](u64 a, u64 b) { return order(a, b) < 0; });
        items.erase(std::unique(items.begin(), items.end(), [&](u64 a, u64 b) { return order(a, b) == 0; }), items.end());
    }
    v.list = arena.list(items);
    return v;
}

// The obvious order: what compare() must agree with.
int slow_compare(Type type, Value a, Value b) {
    if (!type.compound()) return compare(type, a, b);
    const std::size_t n = length(a.list), m = length(b.list);
    if (type.kind() == ValueType::String) {
        const auto text = [](const List* l) {
            return l == nullptr ? std::vector<unsigned char>{}
                                : std::vector<unsigned char>(reinterpret_cast<const unsigned char*>(l->items),
                                                             reinterpret_cast<const unsigned char*>(l->items) + l->count);
        };
        return text(a.list) < text(b.list) ? -1 : text(b.list) < text(a.list) ? 1 : 0;
    }
    for (std::size_t i = 0;; ++i) {
        if (i == n || i == m) return n == m ? 0 : n < m ? -1 : 1;
        if (const int c = slow_compare(type.item(i), item(a.list, i), item(b.list, i))) return c;
    }
}

TEST(Values, RandomTypesSurviveKeepingPackingAndPrinting) {
    Random random(7);
    for (int round = 0; round < 3000; ++round) {
        Types types;
        const Type type = types[random_type(types, random, 3)];
        Arena arena;
        ListStore store(1);
        const Value a = random_value(type, random, arena), b = random_value(type, random, arena);
        SCOPED_TRACE(type_name(type) + " " + print_value(type, a) + " " + print_value(type, b));

        const Value kept = store.keep(type, a, 0);
        EXPECT_EQ(compare(type, a, kept), 0);
        EXPECT_EQ(hash(type, a), hash(type, kept));

        ByteWriter bytes;
        pack(type, kept, bytes);
        pack(type, b, bytes);
        ByteReader in(bytes.view(), "two values");
        EXPECT_EQ(compare(type, unpack(type, in, arena), a), 0);
        EXPECT_EQ(compare(type, unpack(type, in, arena), b), 0);
        EXPECT_TRUE(in.done());

        const std::string text = print_value(type, kept);
        const Result<Value> parsed = parse_value(type, text, arena);
        ASSERT_TRUE(parsed.has_value()) << parsed.error().message();
        EXPECT_EQ(compare(type, *parsed, a), 0) << print_value(type, *parsed);
        EXPECT_EQ(print_value(type, *parsed), text);

        EXPECT_EQ(compare(type, a, b), slow_compare(type, a, b));
        EXPECT_EQ(compare(type, a, b), -compare(type, b, a));
        if (compare(type, a, b) == 0)
            EXPECT_EQ(hash(type, a), hash(type, b));
        else
            EXPECT_NE(hash(type, a), hash(type, b));

        store.release(type, kept, 0);
        EXPECT_EQ(store.bytes(), 0u);
    }
}

TEST(Values, OrderIsThatOfWordsInADictionary) {
    Types types;
    const Type list = types[types.add(ValueType::List, {Types::kInt})];
    const Type string = types[types.add(ValueType::String)];
    Arena arena;
    const auto of = [&](Type type, std::string_view text) { return *parse_value(type, text, arena); };
    const std::vector<std::string> lists{"[]", "[-5]", "[1]", "[1, -9]", "[1, 2]", "[2]"}, strings{"", "B", "a", "aa", "b", "\xff"};
    for (std::size_t i = 0; i + 1 < lists.size(); ++i) EXPECT_LT(compare(list, of(list, lists[i]), of(list, lists[i + 1])), 0) << lists[i];
    for (std::size_t i = 0; i + 1 < strings.size(); ++i)
        EXPECT_LT(compare(string, of(string, strings[i]), of(string, strings[i + 1])), 0) << strings[i];
}

TEST(Values, ThereIsOneZero) {
    Types types;
    const Type list = types[types.add(ValueType::List, {types.add(ValueType::Tuple, {Types::kFloat})})];
    Arena arena;
    ListStore store(1);
    const u64 minus = std::bit_cast<u64>(-0.0);
    const Value v{.list = arena.list({std::bit_cast<u64>(arena.list({minus}))})};
    const Value kept = store.keep(list, v, 0);
    EXPECT_EQ(tuple::item(tuple::item(kept.list, 0).list, 0).catom, 0u);
    EXPECT_EQ(print_value(list, kept), "[(0.0)]");
    EXPECT_EQ(hash(list, v), hash(list, kept));
    EXPECT_EQ(parse_value(types[Types::kFloat], "-0.0", arena)->catom, 0u);
    store.release(list, kept, 0);
}

TEST(Values, PrefixesAreInTheOrderOfTheValues) {
    Random random(11);
    const auto sign = [](u64 a, u64 b) { return a < b ? -1 : b < a ? 1 : 0; };
    for (int round = 0; round < 20000; ++round) {
        Types types;
        Arena arena;
        const Type type = types[random_type(types, random, 2)];
        const Value a = random_value(type, random, arena), b = random_value(type, random, arena);
        const int prefixes = sign(order_prefix(type, a), order_prefix(type, b));
        EXPECT_EQ(prefixes, prefixes == 0 ? 0 : compare(type, a, b));
    }
    // Where a byte is just enough, and as many items as a word has bytes, and more.
    Types types;
    Arena arena;
    const Type list = types[types.add(ValueType::List, {Types::kInt})];
    static constexpr i64 edges[] = {-1, 0, 1, 251, 252, 253, 254, 1000, -1000};
    const auto any = [&] {
        std::vector<u64> items(below(random, 11));
        for (u64& item : items) item = std::bit_cast<u64>(edges[below(random, below(random, 4) == 0 ? 9 : 2)]);
        return Value{.list = arena.list(items)};
    };
    for (int round = 0; round < 50000; ++round) {
        const Value a = any(), b = any();
        const int prefixes = sign(order_prefix(list, a), order_prefix(list, b));
        EXPECT_EQ(prefixes, prefixes == 0 ? 0 : compare(list, a, b));
    }
}

TEST(Values, AnArenaIsUsedAgainAndFreesWhatWasNotNeeded) {
    Arena arena;
    const auto fill = [&](std::size_t lists) {
        std::vector<const List*> all;
        for (std::size_t i = 0; i < lists; ++i) all.push_back(arena.list({i, i + 1, i + 2}));
        all.push_back(arena.list(std::vector<u64>(lists, 7)));
        for (std::size_t i = 0; i < lists; ++i) EXPECT_EQ(all[i]->items[2], i + 2);
        EXPECT_EQ(length(all.back()), lists);
    };
    fill(100000);
    const std::size_t bytes = arena.bytes();
    EXPECT_GT(bytes, 100000 * 5 * sizeof(u64));
    arena.clear();
    fill(100000);
    EXPECT_EQ(arena.bytes(), bytes);
    arena.clear();
    fill(10);
    EXPECT_EQ(arena.bytes(), bytes);
    arena.clear();
    EXPECT_LT(arena.bytes(), bytes / 10);
    fill(10);
    arena.clear(), arena.clear();
    EXPECT_EQ(arena.bytes(), 0u);
    fill(1000);
}

TEST(Values, ACopyInAnArenaIsNobodysAndUnderTheSameLimit) {
    Types types;
    const u16 inner = types.add(ValueType::List, {Types::kFloat});
    const Type outer = types[types.add(ValueType::List, {inner})];
    Arena before, after;
    ListStore store(1);
    const Value value = *parse_value(outer, "[[1.5, -0.0], [], [2.5]]", before);
    const List* copy = store.copy(outer, value.list, after, 0);
    before.clear();
    before.list(std::vector<u64>(20, 0));
    EXPECT_EQ(print_value(outer, {.list = copy}), "[[1.5, 0.0], [], [2.5]]");
    EXPECT_EQ(copy->stored, 0u);
    EXPECT_EQ(store.bytes(), 0u);
    const List empty{nullptr, 0, 0};
    EXPECT_EQ(store.copy(outer, &empty, after, 0), nullptr);
    store.limit(2);
    EXPECT_EQ(store.copy(outer, copy, after, 0), nullptr);
    EXPECT_EQ(store.too_long(0).items, 3u);
}

TEST(Values, KeepingCountsOwnersAndCopiesWhatIsInside) {
    Types types;
    const Type inner = types[types.add(ValueType::List, {Types::kInt})];
    const u16 inner_number = 4;
    const Type outer = types[types.add(ValueType::List, {inner_number})];
    Arena arena;
    ListStore store(2);
    const Value scratch = *parse_value(inner, "[1, 2, 3]", arena);
    const List* kept = store.keep(inner, scratch.list, 0);
    EXPECT_NE(kept, scratch.list);
    EXPECT_EQ(kept->stored, 1u);
    const std::size_t bytes = store.bytes();
    EXPECT_GT(bytes, 3 * sizeof(u64));
    EXPECT_EQ(store.keep(inner, kept, 1), kept);
    EXPECT_EQ(store.bytes(), bytes);

    // A list of kept lists has copies of its own.
    const List* nested = store.keep(outer, arena.list({std::bit_cast<u64>(kept), 0, std::bit_cast<u64>(kept)}), 1);
    store.release(kept, 1);
    store.release(kept, 0);
    EXPECT_EQ(print_value(outer, {.list = nested}), "[[1, 2, 3], [], [1, 2, 3]]");
    // A list inside a block is not a block itself: it is copied when a fact stores it alone.
    const List* first = tuple::item(nested, 0).list;
    EXPECT_EQ(first->stored, 0u);
    const List* alone = store.keep(inner, first, 0);
    EXPECT_NE(alone, first);
    store.release(nested, 0);
    EXPECT_EQ(print_value(inner, {.list = alone}), "[1, 2, 3]");
    store.release(alone, 1);
    EXPECT_EQ(store.bytes(), 0u);
}

TEST(Values, EmptyListsAreNull) {
    Types types;
    const Type list = types[types.add(ValueType::List, {Types::kInt})];
    ListStore store(1);
    const List empty{nullptr, 0, 0};
    EXPECT_EQ(store.keep(list, &empty, 0), nullptr);
    EXPECT_EQ(compare(list, {.list = &empty}, {.list = nullptr}), 0);
    EXPECT_EQ(print_value(list, {.list = nullptr}), "[]");
    store.release(nullptr, 0);
    EXPECT_EQ(store.bytes(), 0u);
}

TEST(Values, ListsThatAreTooLongAreRefused) {
    Types types;
    const u16 string = types.add(ValueType::String);
    const Type list = types[types.add(ValueType::List, {string})];
    Arena arena;
    ListStore store(1);
    store.limit(5);
    const Value fits = store.keep(list, *parse_value(list, "[\"12345\", \"1\"]", arena), 0);
    EXPECT_NE(fits.list, nullptr);
    EXPECT_EQ(store.too_long(0).items, 0u);
    EXPECT_EQ(store.keep(list, *parse_value(list, "[\"123456\"]", arena), 0).list, nullptr);
    EXPECT_EQ(store.keep(list, *parse_value(list, "[\"1234567\"]", arena), 0).list, nullptr);
    const ListStore::Refused refused = store.too_long(0);
    EXPECT_EQ(refused.items, 6u);
    EXPECT_TRUE(refused.text);
    EXPECT_EQ(store.too_long(0).items, 0u);
    store.release(list, fits, 0);
}

TEST(Values, ThreadsShareBlocksAndTheLastOneFrees) {
    Types types;
    const Type list = types[types.add(ValueType::List, {Types::kInt})];
    constexpr int kThreads = 4, kRounds = 20000;
    ListStore store(kThreads);
    Arena arena;
    const List* shared = store.keep(list, parse_value(list, "[1, 2, 3, 4]", arena)->list, 0);
    const u64 expected = hash(list, {.list = shared});
    for (int i = 1; i < kThreads; ++i) store.keep(list, shared, 0);
    std::vector<std::thread> threads;
    std::vector<int> wrong(kThreads, 0);
    for (int t = 0; t < kThreads; ++t)
        threads.emplace_back([&, t] {
            for (int i = 0; i < kRounds; ++i) {
                const List* mine = store.keep(list, shared, t);
                wrong[static_cast<std::size_t>(t)] += hash(list, {.list = mine}) != expected;
                store.release(mine, t);
            }
            store.release(shared, t);
        });
    for (std::thread& t : threads) t.join();
    EXPECT_THAT(wrong, testing::Each(0));
    EXPECT_EQ(store.bytes(), 0u);
}

TEST(ValueText, ReadsWhatPeopleWrite) {
    Types types;
    const Type ints = types[types.add(ValueType::List, {Types::kInt})];
    const Type set = types[types.add(ValueType::Set, {Types::kInt})];
    const Type floats = types[types.add(ValueType::Array, {Types::kFloat})];
    const Type pair = types[types.add(ValueType::Struct, {Types::kInt, Types::kFloat})];
    const Type tuple = types[types.add(ValueType::Tuple, {Types::kNode, Types::kBool})];
    const Type vec3 = types[types.add(ValueType::Vec3)];
    const Type string = types[types.add(ValueType::String)];
    Arena arena;
    const auto read = [&](Type type, std::string_view text) -> std::string {
        const Result<Value> v = parse_value(type, text, arena);
        return v ? print_value(type, *v) : "! " + v.error().message();
    };
    EXPECT_EQ(read(ints, " [1,2 , 3] "), "[1, 2, 3]");
    EXPECT_EQ(read(ints, "nil"), "[]");
    EXPECT_EQ(read(ints, "\"[1, 2]\""), "[1, 2]");
    EXPECT_EQ(read(set, "{3, 1, 3}"), "{1, 3}");
    EXPECT_EQ(read(floats, "[1, -2.50, 1e3]"), "[1.0, -2.5, 1000.0]");
    EXPECT_EQ(read(pair, ":(1, 2)"), ":(1, 2.0)");
    EXPECT_EQ(read(tuple, "(#7, true)"), "(@7, true)");
    EXPECT_EQ(read(vec3, "vec3(1, 2, 3)"), "vec3(1.0, 2.0, 3.0)");
    EXPECT_EQ(read(string, "as it stands"), "\"as it stands\"");
    EXPECT_EQ(read(string, "\"a \\\"b\\\" \\x41\\n\""), "\"a \\\"b\\\" A\\n\"");
    EXPECT_EQ(read(types[Types::kInt], "\"12\""), "12");
    EXPECT_EQ(read(types[types.add(ValueType::List, {4})], "[\"[1]\", [2]]"), "[[1], [2]]");
    EXPECT_EQ(read(string, "\"unfinished"), "\"\\\"unfinished\"");

    EXPECT_EQ(read(ints, "[1, 2"), "! '[1, 2' is no list int. Write it as [12, 12]");
    EXPECT_EQ(read(ints, "[1 2]"), "! '[1 2]' is no list int. Write it as [12, 12]");
    EXPECT_EQ(read(ints, "[1,]"), "! '[1,]' is no list int. Write it as [12, 12]");
    EXPECT_EQ(read(ints, "[1.5]"), "! '[1.5]' is no list int. Write it as [12, 12]");
    EXPECT_EQ(read(ints, "[1] 2"), "! '[1] 2' is no list int. Write it as [12, 12]");
    EXPECT_EQ(read(pair, ":(1)"), "! ':(1)' is no :(int, float). Write it as :(12, 0.5)");
    EXPECT_EQ(read(pair, "(1, 2)"), "! '(1, 2)' is no :(int, float). Write it as :(12, 0.5)");
    EXPECT_EQ(read(tuple, "(@-7, true)"), "! '(@-7, true)' is no (node, bool). Write it as (@7, true)");
    EXPECT_EQ(read(tuple, "(@7, trueish)"), "! '(@7, trueish)' is no (node, bool). Write it as (@7, true)");
    EXPECT_EQ(read(types[Types::kFloat], "inf"), "! 'inf' is no float. Write a number such as 0.5");
    EXPECT_EQ(read(types[Types::kNode], "7"), "! '7' is no catom. Write @ and its number, as @7");
}

}  // namespace
}  // namespace meld::tuple
