#include "runtime/sim/core/programs.h"

#include <fmt/format.h>

#include <span>
#include <vector>

#include "runtime/engine/tuple/facts.h"
#include "runtime/sim/core/setup/unmatched.h"

namespace meld::sim {

Programs::Programs(Subdomain& subdomain) : subdomain_(subdomain) {
    const ModuleInfo& module = subdomain.module;
    const std::optional<u32> sensed = tuple::find_sensed(module, "runs-program", 1);
    // Where there is one program, or all rules are shared, hardly anything reads it.
    if (sensed && module.predicates[*sensed].base != kNone16 && module.predicates[module.predicates[*sensed].base].column != kNone16)
        predicate_ = module.predicates[*sensed].base;
}

std::uint32_t Programs::number_of(Catom catom) const {
    const auto& regions = subdomain_.world.program_regions;
    const auto found =
        std::find_if(regions.rbegin(), regions.rend(), [&](const auto& each) { return subdomain_.members_.in_region(each.where, catom); });
    return found == regions.rend() ? 0 : found->number;
}

void Programs::give(Catom catom, std::uint32_t number) {
    if (!predicate_) return;
    Value value{};
    value.integer = number;
    subdomain_.give(*predicate_, catom, &value);
}

void Programs::begin(Catom catom) {
    if (predicate_) give(catom, number_of(catom));
}

void Programs::complete() {
    for (Catom c = 0; predicate_ && c < subdomain_.ensemble.index_count(); ++c)
        if (subdomain_.owned(c) &&
            tuple::count_facts(subdomain_.module, subdomain_.facts_.columns, subdomain_.geometry(), *predicate_, c) == 0)
            give(c, number_of(c));
}

void Programs::start() {
    const auto& regions = subdomain_.world.program_regions;
    if (regions.empty() && !predicate_) return;
    std::vector<u64> matched(regions.size());
    for (Catom c = 0; c < subdomain_.ensemble.index_count(); ++c) {
        if (!subdomain_.owned(c)) continue;
        std::uint32_t number = 0;
        for (std::size_t i = 0; i < regions.size(); ++i) {
            if (!subdomain_.members_.in_region(regions[i].where, c)) continue;
            ++matched[i];
            number = regions[i].number;
        }
        give(c, number);
    }
    Unmatched unmatched(subdomain_.comm);
    for (std::size_t i = 0; i < regions.size(); ++i)
        unmatched.add(matched[i] > 0, [this, &one = regions[i]] {
            return fmt::format("{}: `{}` matches no catom, so none runs {} for it", one.place, one.where.text(),
                               subdomain_.world.programs[one.number - 1]);
        });
    unmatched.warn();
}

}  // namespace meld::sim
