// Emits the facts of a program's text as tables: one row per fact, its catom and its arguments as words, in the order of catoms.
#include "compiler/emit/writer.h"

namespace meld::emit {

void emit_facts(const plan::Plan& plan, Writer& w) {
    for (const PredicateId id : plan.program.predicates.ids()) {
        const check::Predicate& p = plan.program.predicates[id];
        if (p.world != check::WorldSource::Facts) continue;
        w.raw("");
        w.open(fmt::format("static constexpr u64 {}[{}][{}] = {{", predicate_name(plan.program, id), p.facts.size(), p.arguments.size()));
        for (const check::Fact& f : p.facts) {
            std::string row = fmt::format("{{{}ull", static_cast<std::uint64_t>(f.catom));
            for (std::size_t i = 0; i < f.arguments.size(); ++i) row += ", " + literal_word(f.arguments[i], p.arguments[i + 1].type);
            w.raw(row + "},");
        }
        w.close("};");
    }
}

}  // namespace meld::emit
