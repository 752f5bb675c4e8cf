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
    void begin_step();
    void unpack(u64 id, ByteReader& in);
    void list(std::vector<RecordedArray>& arrays, std::vector<RecordedTable>& tables) const;

  private:
    // The values of one argument, each a word, three words, or a text.
    struct Cells {
        std::vector<u64> words;
        std::vector<std::string> texts;
    };
    struct Argument {
        std::string name, array, type;
        RecordedArray::Type stored = RecordedArray::Int64;
        int components = 1;
        Cells first = {}, all = {};

        RecordedArray cells(const std::string& shown, const Cells& cells) const;
    };
    void pack_fact(const ModuleInfo& module, const Value* fact, ByteWriter& out) const;
    static void take(const Argument& argument, ByteReader& in, Cells& cells);

    u32 predicate_;
    std::string name_;
    bool several_;  // At one catom.
    std::vector<Argument> arguments_;
    std::vector<u64> counts_;  // Of facts, by catom.
    std::vector<u64> catoms_;  // Of all facts.
};

}  // namespace meld::record
