// The facts of a predicate by some of their arguments, for a question that looks for them again and again.
#pragma once

#include <optional>
#include <vector>

#include "runtime/ask/facts/facts.h"
#include "runtime/ask/query/terms.h"
#include "runtime/engine/tuple/values.h"

namespace meld::inspect {

class Index {
  public:
    // `argument_types` are those of the arguments after the catom, `key` the numbers of those it goes by, counted from 1. `at`: only facts
    // of this catom.
    Index(Facts& facts, const Source& source, Types& types, std::vector<check::Type> argument_types, std::vector<std::size_t> key,
          std::optional<u64> at = {});

    // The facts whose key hashes like these values, in the order in which Facts has them; the visit compares. False if it has said so.
    bool each(const std::vector<Value>& key, const Visit& visit) const;
    // Of a source by a key.
    bool is(const Source& source, const std::vector<std::size_t>& key) const { return source_ == source && key_ == key; }
    std::size_t rows() const { return catoms_.size(); }

  private:
    u64 hash(const Value* values) const;  // Of a key.

    static constexpr u32 kEnd = ~u32{0};
    Source source_;
    std::vector<std::size_t> key_;
    Types& types_;
    std::vector<check::Type> argument_types_;
    std::vector<u64> catoms_;
    std::vector<u32> ranks_;
    std::vector<Value> values_;
    tuple::Arena lists_;
    // Chains of rows with one hash, modulo the number of chains.
    std::vector<u32> first_, next_;
};

}  // namespace meld::inspect
