// Strata in which a better value of a min or max may follow from the one it replaces: groups keep their front, the derivations (value,
// rank) that no other one beats in both. rows.h describes T; in addition, group(a, b) orders only the groups, key(a, b) also the values,
// better(a, b) compares the values, hash(row) names the group.
#pragma once

#include "runtime/module/kernel/views.h"

namespace meld {

// Whether `a` makes `b` superfluous: what b supports, a supports too, and what follows from b is beaten by what follows from a. Both are of
// one group.
template <class T>
bool beats(const typename T::Row& a, const typename T::Row& b) {
    return !T::better(b, a) && a.rank <= b.rank;
}

// By group, then the better value, then the lower rank.
template <class T>
struct FrontOrder {
    bool operator()(const typename T::Row& a, const typename T::Row& b) const {
        if (const int k = T::group(a, b)) return k < 0;
        if (T::better(a, b)) return true;
        if (T::better(b, a)) return false;
        if (a.rank != b.rank) return a.rank < b.rank;
        return T::key(a, b) < 0;
    }
};

// Takes the steps of Mutual (mutual.h) with the other predicates of the stratum.
template <class T>
struct Front : Mutual<T> {
    using Row = typename T::Row;
    using Base = Mutual<T>;
    using Base::kept, Base::lost, Base::old, Base::old_count, Base::r, Base::trusted;

    using Base::Base;

    // An element is not lost if another one beats it.
    MELD_STEP void lose(Eval& e) {
        if constexpr (T::kLinks)
            for (u32 i = 0; i < old_count; ++i) {
                if (kept[i] || !Base::was_there(old[i])) continue;
                bool superseded = false;
                for (u32 k = 0; k < r.count && !superseded; ++k)
                    superseded = T::group(r.rows[k], old[i]) == 0 && beats<T>(r.rows[k], old[i]);
                for (u32 k = 0; k < r.proposed.count && !superseded; ++k) {
                    const Row& p = r.proposed.rows[k];
                    superseded = T::group(p, old[i]) == 0 && beats<T>(p, old[i]) && trusted(e, p) <= e.subdomain->now;
                }
                if (superseded) continue;
                lost.add(e, old[i]);
                e.host->lose(&e, r.predicate.value(), T::hash(old[i]), old[i].rank);
            }
        r.start_round();
    }
    // Groups take all trusted proposals that no other beats, and drop the elements that these beat. A value that exists keeps its rank.
    MELD_STEP bool take(Eval& e) {
        const auto group = [](const Row& a, const Row& b) { return T::group(a, b); };
        return Base::take_groups(e, FrontOrder<T>{}, group, [&](RowList<Row>& next, u32& held, const Row* first, const Row* end) {
            const u32 begin = next.count;
            while (held < r.count && T::group(r.rows[held], *first) == 0) next.add(e, r.rows[held++]);
            bool grew = false;
            for (const Row* p = first; p != end; ++p) grew = join(e, next, begin, *p) || grew;
            sort_rows(e, next.rows + begin, next.count - begin, [](const Row& a, const Row& b) { return T::key(a, b) < 0; });
            return grew;
        });
    }

  private:
    // Whether the proposal joined its group, whose rows start at `first`.
    bool join(Eval& e, RowList<Row>& rows, u32 first, const Row& p) {
        KERNEL_CHECK(e, first <= rows.count && (first == rows.count || T::group(rows.rows[first], p) == 0));
        for (u32 i = first; i < rows.count; ++i) {
            const Row& other = rows.rows[i];
            const bool same_value = !T::better(p, other) && !T::better(other, p);
            if (same_value || beats<T>(other, p)) return false;
        }
        if (!Base::may_enter(e, p)) return false;
        u32 left = first;
        for (u32 i = first; i < rows.count; ++i)
            if (!beats<T>(p, rows.rows[i])) rows.rows[left++] = rows.rows[i];
        rows.count = left;
        rows.add(e, p);
        note_rank(e, p.rank);
        return true;
    }
};

}  // namespace meld
