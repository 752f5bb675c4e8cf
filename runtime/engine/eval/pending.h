// What an evaluation of a catom leaves to be done at the end of the tick. Private to runtime/engine/eval.
#pragma once

#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

// Of exported columns: what takes the place of the rows or the record of a catom, or changes its rows.
struct PendingRows {
    u32 catom;
    u16 column;
    u32 count;
    u8* rows;
};
struct PendingChanges {
    u32 catom;
    u16 column;
    RowChanges* changes;
};
struct PendingRecord {
    u32 catom;
    u16 column;
    u8* record;
};
// A group has lost a fact of this rank.
struct Loss {
    u32 catom;
    u16 predicate;
    u64 key;
    u32 rank;
};
// A group, or a catom, is to be looked at again in a later tick.
struct GroupWake {
    i64 tick;
    u32 catom;
    u16 column;
    const u8* row;
};
struct Wake {
    i64 tick;
    u32 catom;
    u64 dirty;
};

}  // namespace meld::eval
