#include "runtime/ask/query/index.h"

#include <bit>
#include <utility>

#include "runtime/base/hash.h"

namespace meld::inspect {

Index::Index(Facts& facts, const Source& source, Types& types, std::vector<check::Type> argument_types, std::vector<std::size_t> key,
             std::optional<u64> at)
    : source_(source), key_(std::move(key)), types_(types), argument_types_(std::move(argument_types)) {
    const std::size_t arity = source.arity;
    const auto keep = [&](const Fact& fact) {
        catoms_.push_back(fact.catom);
        ranks_.push_back(fact.rank);
        for (std::size_t i = 0; i < arity; ++i) {
            Value v = fact.arguments[i];
            // What is read from the ensemble lasts no longer than the visit.
            if (source.kind == Source::Kind::World && argument_types_[i].compound()) {
                ByteWriter packed;
                tuple::pack(types_.of(argument_types_[i]), v, packed);
                ByteReader in(packed.view(), "a value of an index");
                v = tuple::unpack(types_.of(argument_types_[i]), in, lists_);
            }
            values_.push_back(v);
        }
        return true;
    };
    if (at)
        facts.at(source, *at, keep);
    else
        facts.each(source, keep);
    first_.assign(std::bit_ceil(catoms_.size() + 1), kEnd);
    next_.resize(catoms_.size());
    std::vector<Value> known(key_.size());
    for (std::size_t row = catoms_.size(); row-- > 0;) {
        for (std::size_t i = 0; i < key_.size(); ++i) known[i] = values_[row * arity + key_[i] - 1];
        u32& chain = first_[hash(known.data()) & (first_.size() - 1)];
        next_[row] = chain;
        chain = static_cast<u32>(row);
    }
}

u64 Index::hash(const Value* values) const {
    u64 h = 0;
    for (std::size_t i = 0; i < key_.size(); ++i) {
        const tuple::Type type = types_.of(argument_types_[key_[i] - 1]);
        h = hash_combine(h, tuple::hash(type, tuple::normal(type.kind(), values[i])));
    }
    return h ^ h >> 32;
}

bool Index::each(const std::vector<Value>& key, const Visit& visit) const {
    for (u32 row = first_[hash(key.data()) & (first_.size() - 1)]; row != kEnd; row = next_[row])
        if (!visit({.catom = catoms_[row], .arguments = values_.data() + std::size_t{row} * source_.arity, .rank = ranks_[row]}))
            return false;
    return true;
}

}  // namespace meld::inspect
