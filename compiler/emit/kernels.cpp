// Emits, for a module that is compiled in pieces, which of the kernel's functions its row types need. All pieces see that there are such
// functions; each is compiled once, in the part of its type.
#include <map>
#include <set>

#include "compiler/emit/emit.h"
#include "compiler/emit/writer.h"

namespace meld::emit {

using namespace check;
using plan::Recursion;
using plan::StratumPlan;

namespace {

// The functions of one row type, each as what follows `template ` in an explicit instantiation.
class Kernels {
  public:
    Kernels(const plan::Plan& plan, PredicateId id, const std::string& type) : plan_(plan), id_(id), t_("program::" + type) {}

    std::set<std::string> functions(const StratumPlan* stratum) {
        add("void meld::RowList<{0}::Row>::grow(meld::Eval&)");
        if (has_deltas(plan_) && !plan_.program.predicates[id_].linear())
            add("const meld::RowChanges* meld::own_changes<{0}>(meld::Eval&, meld::Relation<{0}>&)");
        if (stratum != nullptr) of_stratum(*stratum);
        return std::move(all_);
    }

  private:
    void add(const char* function) { all_.insert(fmt::format(fmt::runtime(function), t_)); }

    void of_stratum(const StratumPlan& s) {
        const bool by_round = s.grows(id_);
        const bool own = !calls_catom(plan_, id_);
        if (!by_round) add("void meld::Relation<{0}>::propose(meld::Eval&, const {0}::Row&)");
        switch (s.recursion) {
            case Recursion::None:
            case Recursion::Tree:
            case Recursion::Rounds:
                if (own)
                    add("bool meld::evaluate_plain<{0}, meld::OwnCombine<{0}>>(meld::Eval&, meld::Relation<{0}>&, const "
                        "meld::OwnCombine<{0}>&, meld::u32)");
                break;
            case Recursion::LocalSets:
                if (by_round)
                    add("bool meld::Rounds<{0}>::finish(meld::Eval&, meld::Relation<{0}>&, const {0}::Row*, meld::u32)");
                else
                    add("bool meld::gather<{0}>(meld::Eval&, meld::Relation<{0}>&)");
                break;
            case Recursion::Ranked:
                add("bool meld::evaluate_ranked<{0}>(meld::Eval&, meld::Relation<{0}>&)");
                break;
            case Recursion::Mutual:
                for (const char* step : {"keep", "lose", "take"}) {
                    const bool front = plan_.program.predicates[id_].front != Aggregate::None && std::string(step) != "keep";
                    all_.insert(fmt::format("{} meld::{}<{}>::{}(meld::Eval&)", std::string(step) == "lose" ? "void" : "bool",
                                            front ? "Front" : "Mutual", t_, step));
                }
                break;
        }
        if (s.deltas.inputs != 0) of_deltas(own);
    }
    void of_deltas(bool own) {
        add("void meld::AffectedGroups<{0}>::add(meld::Eval&, const {0}::Row&)");
        add("void meld::AffectedGroups<{0}>::add_woken(meld::Eval&, const meld::RowChanges*)");
        add("void meld::AffectedGroups<{0}>::find_places(meld::Eval&, const meld::Relation<{0}>&)");
        add("bool meld::AffectedGroups<{0}>::few(meld::Eval&, const meld::Relation<{0}>&)");
        add("void meld::AffectedGroups<{0}>::ask_around(const meld::Relation<{0}>&, const meld::RowsHead*, const meld::i32*, meld::i32) "
            "const");
        add("meld::u32 meld::find_row<{0}>(const {0}::Row*, meld::u32, const {0}::Row&, meld::Near)");
        if (own)
            add("bool meld::evaluate_affected<{0}, meld::OwnCombine<{0}>>(meld::Eval&, meld::Relation<{0}>&, const "
                "meld::AffectedGroups<{0}>&, const meld::OwnCombine<{0}>&, meld::u32)");
    }

    const plan::Plan& plan_;
    PredicateId id_;
    std::string t_;
    std::set<std::string> all_;
};

}  // namespace

void emit_kernels(const plan::Plan& plan, const std::map<PredicateId, std::string>& row_types, Writer& w) {
    std::map<PredicateId, const StratumPlan*> strata;
    for (const StratumPlan& s : plan.strata)
        for (const PredicateId p : s.predicates) strata[p] = &s;
    std::map<std::string, std::set<std::string>> kernels;
    for (const auto& [id, type] : row_types) {
        const auto stratum = strata.find(id);
        kernels[type].merge(Kernels(plan, id, type).functions(stratum == strata.end() ? nullptr : stratum->second));
    }
    w.part("", Writer::Where::Kernel);
    const std::string sort =
        "template void meld::sort_bytes<0>(meld::Eval&, meld::u8*, meld::u32, meld::u32, bool (*)(const void*, const void*));";
    w.line("extern {}", sort);
    for (const auto& [type, functions] : kernels)
        for (const std::string& function : functions) w.line("extern template {};", function);
    w.part(kKernelPart, Writer::Where::Kernel);
    w.raw(sort);
    for (const auto& [type, functions] : kernels) {
        w.part(kKernelPart + " of " + type, Writer::Where::Kernel);
        for (const std::string& function : functions) w.line("template {};", function);
    }
}

}  // namespace meld::emit
