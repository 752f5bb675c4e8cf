// A program may have a predicate of its own by the name of a sensed one, with other types. If rules read it and none derives it, the sensed
// one was meant, and these rules would wait for it for ever. Assumes resolve_rules().
#include <vector>

#include "compiler/check/check.h"
#include "compiler/check/names/later_fixes.h"

namespace meld::check {

using diagnostics::Kind;

void refuse_hidden_senses(Program& program, diagnostics::Reporter& report) {
    // A rule that has an error might have derived it.
    if (report.has_errors()) return;
    std::vector<bool> derived(program.predicates.count(), false);
    std::vector<const Atom*> read(program.predicates.count(), nullptr);
    const auto reads = [&](const Atom& a, bool) {
        if (read[a.predicate.index()] == nullptr) read[a.predicate.index()] = &a;
    };
    for (const Rule& rule : program.rules) {
        each_atom(rule.body, reads);
        each_head(rule.heads, [&](const Head& h) {
            each_atom(h.body, reads);
            if (h.kind == Head::Kind::Fact) derived[h.atom.predicate.index()] = true;
        });
    }
    for (const PredicateId id : program.predicates.ids()) {
        Predicate& p = program.predicates[id];
        if (!p.hides || derived[id.index()] || read[id.index()] == nullptr) continue;
        auto& d =
            report.add(Kind::SensedMismatch, p.span,
                       fmt::format("`{}` is not the predicate that the runtime senses, and no rule derives it: it never holds", p.name));
        d.labels = {{p.hides->span, "this one is sensed"}, {read[id.index()]->span, "so this never matches"}};
        d.help = fmt::format("write `{}` to read what is sensed, or give a predicate of your own another name", p.hides->declaration);
        d.fixes = {diagnostics::write(p.declaration, without_stop(p.hides->declaration))};
        p.refused = true;
    }
}

}  // namespace meld::check
