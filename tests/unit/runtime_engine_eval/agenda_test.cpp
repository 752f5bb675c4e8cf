#include "runtime/engine/eval/agenda.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "runtime/base/process/parallel_for.h"

namespace meld::eval {
namespace {

std::map<u32, u64> words_of(const Agenda& agenda) {
    std::map<u32, u64> all;
    u32 last = 0;
    agenda.each([&](u32 catom, u64 dirty) {
        EXPECT_TRUE(all.empty() || catom > last) << catom << " after " << last;
        last = catom;
        all.emplace(catom, dirty);
    });
    return all;
}

TEST(Agenda, GivesEachCatomTheBitsThatWereMarked) {
    Agenda agenda;
    std::map<u32, u64> expected;
    std::mt19937 random(1);
    for (u32 catoms : {500U, 70000U}) {
        agenda.resize(catoms);
        for (int i = 0; i < 1000; ++i) {
            const u32 catom = static_cast<u32>(random() % catoms);
            const u64 bits = i % 7 == 0 ? u64{kDirtyBirths} : u64{1} << (1 + random() % (kDirtyWordBits - 1));
            agenda.mark(catom, bits);
            expected[catom] |= bits;
        }
    }
    EXPECT_EQ(words_of(agenda), expected);
    for (const auto& [catom, bits] : expected) EXPECT_EQ(agenda.dirty(catom), bits);
    agenda.clear();
    EXPECT_TRUE(agenda.empty());
    EXPECT_TRUE(words_of(agenda).empty());
}

TEST(Agenda, MarksManyAsOneAfterTheOther) {
    std::mt19937 random(2);
    std::vector<u32> catoms(3000);
    for (u32& catom : catoms) catom = static_cast<u32>(random() % 70000);
    for (const u64 bits : {u64{kDirtyBirths}, u64{kDirtyLinks | kFirstModuleBit}}) {
        Agenda many, single;
        for (Agenda* agenda : {&many, &single}) agenda->resize(70000);
        many.mark_all(catoms, bits);
        for (const u32 catom : catoms) single.mark(catom, bits);
        EXPECT_EQ(words_of(many), words_of(single));
        EXPECT_EQ(words_of(many).begin()->second, bits);
    }
}

TEST(Agenda, ForgetsOneCatomOfAGroup) {
    Agenda agenda;
    agenda.resize(100);
    for (const u32 catom : {63U, 64U, 65U}) agenda.mark(catom, kDirtyLinks | kFirstModuleBit);
    agenda.forget(64);
    EXPECT_EQ(words_of(agenda), (std::map<u32, u64>{{63, kDirtyLinks | kFirstModuleBit}, {65, kDirtyLinks | kFirstModuleBit}}));
    EXPECT_EQ(agenda.dirty(64), 0U);
}

TEST(Agenda, TakesMarksFromSeveralThreads) {
    Agenda agenda;
    agenda.resize(10000);
    Workers workers(4);
    workers.run(100, [&](int, std::size_t part) {
        for (u32 i = 0; i < 1000; ++i) agenda.mark_shared((static_cast<u32>(part) * 77 + i * 3) % 10000, kFirstModuleBit << part % 3);
    });
    Agenda alone;
    alone.resize(10000);
    for (u32 part = 0; part < 100; ++part)
        for (u32 i = 0; i < 1000; ++i) alone.mark((part * 77 + i * 3) % 10000, kFirstModuleBit << part % 3);
    EXPECT_EQ(words_of(agenda), words_of(alone));
}

TEST(Agenda, TakesAnEighthOfAByteForEachBitInUse) {
    Agenda agenda;
    agenda.resize(64000);
    agenda.mark(5, kFirstModuleBit);
    agenda.mark(63999, kDirtyBirths);
    EXPECT_LE(agenda.bytes(), Agenda::bytes_for(64000, 2) + 64);
}

}  // namespace
}  // namespace meld::eval
