// What a recording has of one predicate: of each catom the first fact and how many there are, and of a predicate that can have several
// at a catom a table of all. Private to runtime/results/record.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/large_array.h"
#include "runtime/base/process/liveness.h"
#include "runtime/results/record/recording.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::record {

// Catoms of this process and their rows in a step, in the order of these.
struct RowsOfCatoms {
    std::span<const u32> rows;
    std::span<const sim::Catom> catoms;
    template <class Visit>
    void each(const Visit& visit) const {
        for (std::size_t i = 0; i < rows.size(); ++i) {
            liveness::beat();
            visit(rows[i], catoms[i]);
        }
    }
};

class RecordedPredicate {
  public:
    // `name` is that of its arrays and of its table.
    RecordedPredicate(const ModuleInfo& module, u32 predicate, std::string name);

    const std::string& name() const { return name_; }
    u32 predicate() const { return predicate_; }
    bool has_table() const { return several_; }
    // What readers need to make facts of the arrays and tables, as an object of JSON.
    std::string description() const;

    // On every process: the facts of a catom. skip() passes over them again.
    void pack(sim::Subdomain& subdomain, sim::Catom catom, ByteWriter& out) const;
    void skip(ByteReader& in) const;

    // On the process that writes: a step, catom by catom in the order of their ids. What list() adds refers to this object until the next
    // begin_step().
    void begin_step(std::size_t rows);
    void unpack(u64 id, ByteReader& in);
    // The same of all catoms of a run of one process, in the order of their ids.
    void read(sim::Subdomain& subdomain, std::span<const sim::Catom> catoms);
    // The step after one of the same catoms: between the first and the last of these, update() for those of which something may have
    // changed, in the order of their ids, each with its row.
    void begin_update();
    void update(std::size_t row, u64 id, ByteReader& in);
    void update(sim::Subdomain& subdomain, const RowsOfCatoms& rows);
    void end_update();
    void list(std::vector<RecordedArray>& arrays, std::vector<RecordedTable>& tables) const;

  private:
    // The values of one argument, each a word, three words, or a text.
    struct Cells {
        LargeArray<u64> words;
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
    // What stands for the facts of a catom that has none: of a number, a word.
    static u64 nothing(const Argument& argument);
    // Of a predicate that is simple: visit(count_of(catom)) once, and visit(argument, word_of(catom)) for each argument.
    template <class Visit>
    void with_count_of(const sim::Subdomain& subdomain, const Visit& visit) const;
    template <class Visit>
    void each_argument(const sim::Subdomain& subdomain, const Visit& visit);
    void set_count(std::size_t row, u64 count);
    static void take(const Argument& argument, ByteReader& in, Cells& cells);
    static void take_first(const Argument& argument, std::uint32_t count, ByteReader& in, Cells& cells);

    u32 predicate_;
    std::string name_;
    bool several_;  // At one catom.
    bool simple_;   // At most one at a catom, of numbers, or any number without arguments: there is a faster way to them.
    std::vector<Argument> arguments_;
    LargeArray<u64> counts_;   // Of facts, by catom.
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
