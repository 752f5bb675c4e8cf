// What a recording has of one predicate: of each catom the first fact and how many there are, and of a predicate that can have several
// at a catom a table of all. Private to runtime/results/record.
#pragma once

#include <string>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/results/record/recording.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::record {

class RecordedPredicate {
  public:
    // `name` is that of its arrays and of its table.
    RecordedPredicate(const ModuleInfo& module, u32 predicate, std::string name);

    const std::string& name() const { return name_; }
    u32 predicate() const { return predicate_; }
    // What readers need to make facts of the arrays and tables, as an object of JSON.
    std::string description() const;

    // On every process: the facts of a catom. skip() passes over them again.
    void pack(sim::Subdomain& subdomain, sim::Catom catom, ByteWriter& out) const;
    void skip(ByteReader& in) const;

    // On the process that writes: a step, catom by catom in the order of their ids. What list() adds refers to this object until the next
    // begin_step().
    void begin_step(std::size_t rows);
    void unpack(u64 id, ByteReader& in);
    // The step after one of the same catoms: between the first and the last of these, update() for those of which something may have
    // changed, in the order of their ids, each with its row.
    void begin_update();
    void update(std::size_t row, u64 id, ByteReader& in);
    void end_update();
    void list(std::vector<RecordedArray>& arrays, std::vector<RecordedTable>& tables) const;

  private:
    // The values of one argument, each a word, three words, or a text.
    struct Cells {
        std::vector<u64> words;
        std::vector<std::string> texts;
        bool same = false;              // As in the step before.
        std::vector<u64> changed = {};  // The rows that are not, in an update.
        bool operator==(const Cells& other) const { return words == other.words && texts == other.texts; }
        void clear() {
            words.clear();
            texts.clear();
        }
    };
    struct Argument {
        std::string name, array, type;
        RecordedArray::Type stored = RecordedArray::Int64;
        int components = 1;
        Cells first = {}, all = {}, fresh = {}, room = {};

        void put(std::size_t row);
        void append(const Cells& from, std::size_t first_row, std::size_t rows);

        RecordedArray cells(const std::string& shown, const Cells& cells, bool updated) const;
    };
    void pack_fact(const ModuleInfo& module, const Value* fact, ByteWriter& out) const;
    static void take(const Argument& argument, ByteReader& in, Cells& cells);
    static void take_first(const Argument& argument, std::uint32_t count, ByteReader& in, Cells& cells);

    u32 predicate_;
    std::string name_;
    bool several_;  // At one catom.
    std::vector<Argument> arguments_;
    std::vector<u64> counts_;  // Of facts, by catom.
    std::vector<u64> catoms_;  // Of all facts.
    std::vector<u64> changed_counts_;
    bool updated_ = false, counts_same_ = false, table_same_ = false;
    // Of an update: the catoms whose facts in the table are others now, and how many; the facts are in `fresh` of the arguments.
    struct Fresh {
        u64 id;
        std::uint32_t count;
    };
    std::vector<Fresh> fresh_;
};

}  // namespace meld::record
