// Emits the facts of a program's text as tables: one row per fact, its catom and its arguments as words, in the order of catoms.
#include <string>
#include <vector>

#include "compiler/emit/writer.h"

namespace meld::emit {

void emit_facts(const plan::Plan& plan, Writer& w) {
    for (const PredicateId id : plan.program.predicates.ids()) {
        const check::Predicate& p = plan.program.predicates[id];
        if (p.world != check::WorldSource::Facts) continue;
        const std::string name = predicate_name(plan.program, id);
        std::vector<std::string> rows;
        std::string lists;
        int number = 0;
        for (const check::Fact& f : p.facts) {
            std::string row = fmt::format("{{{}ull", static_cast<std::uint64_t>(f.catom));
            for (std::size_t i = 0; i < f.arguments.size(); ++i)
                row += ", " + literal_word(f.arguments[i], p.arguments[i + 1].type, lists, number);
            rows.push_back(row + "},");
        }
        w.raw("");
        if (lists.empty() && plan.in_pieces()) {
            w.line("extern const u64 {}[{}][{}];", name, p.facts.size(), p.arguments.size());
            w.part(fmt::format("facts of {}", p.name));
            w.open(fmt::format("extern const u64 {}[{}][{}] = {{", name, p.facts.size(), p.arguments.size()));
            for (const std::string& row : rows) w.raw(row);
            w.close("};");
            w.part("");
            continue;
        }
        // Other tables have lists of the same names.
        if (!lists.empty()) {
            w.line("namespace lists_of_{} {{", name);
            w.raw(lists);
        }
        // The address of a list is no constant expression.
        w.open(
            fmt::format("static {} u64 {}[{}][{}] = {{", lists.empty() ? "constexpr" : "const", name, p.facts.size(), p.arguments.size()));
        for (const std::string& row : rows) w.raw(row);
        w.close("};");
        if (!lists.empty()) w.line("}}\nusing lists_of_{0}::{0};", name);
    }
}

}  // namespace meld::emit
