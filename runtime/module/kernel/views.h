// The evaluation steps that every emitted module shares, as templates over its row types. Emitted code includes this one
// header; a rule becomes a plain loop that adds candidates, and these templates decide what holds. Here are the steps of
// predicates without recursion over links; those with it are in ranks.h and mutual.h.
//
// rows.h describes T.
#pragma once

#include "runtime/module/kernel/aggregates.h"
#include "runtime/module/kernel/bags.h"
#include "runtime/module/kernel/mutual.h"
#include "runtime/module/kernel/ranks.h"
#include "runtime/module/kernel/relation.h"

namespace meld {

// Not recursive: the proposals are complete, so reduce each group and compare with the previous result. Cost: one sort of the proposals.
// combine, needed: as for reduce_group(). Returns whether anything changed.
template <class T, class Combine = OwnCombine<T>>
MELD_STEP bool evaluate_plain(Eval& e, Relation<T>& r, const Combine& combine = {}, u32 needed = 0) {
    using Row = typename T::Row;
    Row* p = r.proposed.rows;
    const u32 n = r.proposed.count;
    sort_candidates<T>(e, p, n);
    u32 kept = 0;
    for (u32 i = 0; i < n;) {
        u32 end = i + 1;
        while (end < n && T::key(p[end], p[i]) == 0) ++end;
        const Row* held = nullptr;
        if constexpr (T::kReduce == Reduce::First || T::kReduce == Reduce::Since)
            if (const u32 at = r.find(p[i]); at < r.count) held = &r.rows[at];
        Row out;
        if (reduce_group<T>(e, held, p + i, end - i, combine, needed, out)) p[kept++] = out;
        i = end;
    }
    KERNEL_CHECK(e, one_a_group<T>(p, kept));
    KERNEL_CHECK(e, one_a_group<T>(r.rows, r.count));
    check_view_limit<T>(e, kept, r.rule);
    r.start_round();
    if (equal_rows<T>(r.rows, r.count, p, kept)) return false;
    r.replace(p, kept);
    return true;
}

// Recursive through local rules only, sets without aggregates: computed from scratch within the tick, nothing stored.
template <class T>
MELD_STEP bool gather(Eval& e, Relation<T>& r) {
    using Row = typename T::Row;
    Row* p = r.proposed.rows;
    const u32 n = r.proposed.count;
    sort_rows(e, p, n, ChoiceOrder<T>{});
    KERNEL_CHECK(e, one_a_group<T>(r.rows, r.count));
    RowList<Row> next;
    next.reset();
    u32 held = 0;
    bool grew = false;
    for (u32 i = 0; i < n; ++i) {
        if (i > 0 && T::key(p[i - 1], p[i]) == 0) continue;
        while (held < r.count && T::key(r.rows[held], p[i]) < 0) next.add(e, r.rows[held++]);
        if (held < r.count && T::key(r.rows[held], p[i]) == 0) continue;
        next.add(e, p[i]);
        grew = true;
    }
    while (held < r.count) next.add(e, r.rows[held++]);
    return r.end_round(e, next, grew);
}

}  // namespace meld
