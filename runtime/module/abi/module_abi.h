// The interface between a compiled module and the runtime. Any change of this file that a module can notice raises kAbiVersion; a module of
// another version is rejected before it is loaded. No standard library.
//
// The order of calls. A module exports one function, claymeld_module(), and the runtime calls what it returns; all other calls
// go the other way, through Host.
//
// Load, once a process:
//   1. The runtime reads the module's note (module_note.h) and rejects another abi_version or processor.
//   2. It opens the module and calls claymeld_module() once. The ModuleInfo and all it points to live as long as the run.
//   3. It makes the columns, gives the parameters their values, and marks every catom with kDirtyBirths; if the module says that births
//      are idle, only those that were given facts.
//
// In every tick, after SubdomainView::now has been raised, timers have marked the catoms that asked to be woken, and the central modules,
// events of the world and hand-written modules have run:
//   4. Threads take blocks of the marked catoms, in ascending order, and call evaluate(Eval*, catoms, dirty, count) for each
//      block; several threads at a time, each with its own Eval. No catom is in two blocks. While any of these calls
//      runs, exported columns, `changes` and the geometry are as they were at the end of the last tick.
//   5. Within evaluate, for one catom after the other, with Eval::catom set and the arena empty:
//        a. Rules and functions call more_arena, reserve, give_back, empty, random and position at any time; tombstone before a
//           group is decided; lose when a fact has been retracted; wake and wake_group when a quarantine or a delay ends later. If a
//           derivation of a view traps, it counts as absent and they call note_undefined, after forget_undefined if its stratum had
//           undefined derivations; before any of them they call undefined, if SubdomainView::undefined is set.
//        b. When a linear rule fires: next_hop, new_node, send, send_row, send_far, bear and act, in the order of its heads. The facts
//           consumed and produced change only in the module, and the views are evaluated again, until no rule fires. Before a linear
//           rule, or c., reads what an undefined derivation makes uncertain: undefined_rule and stop_undefined, which is a trap.
//        c. When everything has reached its fixpoint: act for the actions that views derive, and wake for the next tick if a rule
//           reads it.
//        d. Last, and only if no trap is set: export_record, assign_rows or change_rows, once for each column that has changed.
//           Private columns change with this call; the module itself writes their records and rows where they contain no lists and
//           the rows fit into their block. So a catom whose rules trapped has stored nothing; a trap while it stores
//           (a list that is too long) ends the run with some of its columns stored.
//      After a trap evaluate returns; the rest of its block is not evaluated, but other blocks are.
//   6. When all blocks are done: the exported records, rows and changes become visible, each marking the neighbours with the
//      column's reader_dirty; or only those that ColumnInfo::concerned names, once all records are visible. Then losses are stored,
//      timers set, and messages sorted by receiver, sender and number.
//      Where nobody looks on, facts for all neighbours alike are not among them: the neighbours read them in the next tick (Broadcast).
//   7. Rows that were sent are put in order with arrange and compare_rows, and messages are delivered as given facts; messages for
//      other processes and changed exports are exchanged; receivers are marked and see these facts in the next tick. Actions are
//      carried out at the start of the next tick, in order of catom id.
//
// A run ends between two ticks; a module is never called to end it.
#pragma once

#include "runtime/module/abi/geometry_abi.h"
#include "runtime/module/abi/storage_abi.h"

namespace meld {

inline constexpr u32 kAbiVersion = 31;
inline constexpr u16 kNone16 = 0xffff;
inline constexpr u32 kNone32 = 0xffffffff;

// A value of more than one word, immutable: a list, set, array, struct, tuple, vec3 or string. Null is the empty list, set, array or
// string. Rules make them in scratch memory; the runtime copies what a fact keeps into its own blocks, which count the facts that share
// them (runtime/engine/tuple/values.h). So passing a list on from fact to fact never copies it, and nothing is compared by address alone.
struct List {
    const u64* items;  // Elements or fields, one word each as in Value; for a string its bytes.
    u32 count;         // Elements, fields or bytes.
    u32 stored;        // 1: the start of a block of the runtime; 0: in scratch memory, in the module, or inside a block.
};

union Value {
    i64 integer;       // Int, and Bool as 0 or 1
    double real;       // Float
    u64 catom;         // Node: a global id
    const List* list;  // All others
};

enum class ValueType : u8 { Int, Float, Bool, Node, String, List, Set, Array, Struct, Tuple, Vec3 };

// A type of values of more than one word. Sets are sorted and hold each element once.
struct TypeInfo {
    ValueType kind;
    u16 part_count;    // List, Set, Array: 1; Struct, Tuple: the fields; String, Vec3: 0.
    const u16* parts;  // Indices into ModuleInfo::types, whose first four are Int, Float, Bool and Node.
};
inline constexpr u16 kScalarTypes = 4;
enum class Storage : u8 {
    Flag,     // a bit in a record
    Single,   // at most one row a catom, in a record
    PerLink,  // at most one row a catom and port, in a record
    Rows,     // any number of rows
    World,    // not stored: read from the ensemble
};
enum class PredicateKind : u8 { Persistent, Linear, Action, Sensed };

struct FieldInfo {
    const char* name;
    ValueType type;
    u8 bytes;    // Bool: 1; Int: 1, 2, 4 or 8, as many as its values need; all others 8.
    u32 offset;  // In the record (Single), in the row (Rows), of port 0 in the record (PerLink).
    u16 deep;    // Index into ModuleInfo::types.
};

struct PredicateInfo {
    const char* name;
    PredicateKind kind;
    Storage storage;
    bool auxiliary;  // Made by the compiler, or an unused predicate of the prelude: not shown to users.
    bool repeats;    // An action carried out in every tick in which it holds.
    u16 arity;       // Without the catom.
    const FieldInfo* fields;
    u16 column;           // kNone16 where Storage::World.
    u16 base;             // The predicate that stores facts given from outside (itself or an auxiliary), or kNone16.
    u32 rank_offset;      // In the record or row, or kNone32.
    u32 presence_offset;  // Flag, Single without rank: a byte in the record; PerLink: the u32 mask of ports.
    u32 presence_mask;
    bool read = true;    // Some rule reads it.
    bool route = false;  // Its first field is the catom it leads to.
    // Linear, without arguments: a catom that is evaluated with kDirtyTurn has one more of it than is stored. If some are left, the module
    // stores them and says so (Eval::still_activated).
    bool by_turn = false;
};

struct Eval;

struct ColumnInfo {
    const char* name;
    bool rows;          // Each entry is a RowsHead; otherwise a record.
    bool exported;      // Read by neighbours: committed at the end of a tick and mirrored in ghosts.
    u32 stride;         // Bytes a catom.
    u32 row_bytes;      // Of one row, if `rows`.
    u64 own_dirty;      // The bits to mark at the catom itself when the runtime changes this column.
    u64 reader_dirty;   // The bits to mark at its neighbours when the column has changed.
    const u8* initial;  // A new catom's record, stride bytes; null: zero.
    // Offsets in the record or row of the words that point to lists, and their types; the runtime counts these references.
    u32 list_count;
    const u32* list_offsets;
    const u16* list_types;
    // If delta rules follow single rows: the order of two rows' groups. Null: changes of this column are not recorded by row.
    int (*compare_groups)(const void* a, const void* b);
    // If it holds linear facts: the order of two rows by all their fields, and a function for few of them: it sorts the rows from
    // `rows + held_count` on, `count` of them, and merges them with the sorted rows `held`, which are elsewhere.
    int (*compare_rows)(const void* a, const void* b);
    void (*arrange)(void* rows, const void* held, u32 held_count, u32 count);
    // Of these neighbours of a catom whose record has changed, with -1 for none: writes to `out` those whose evaluation can come to another
    // result because of it, and returns how many there are. The column is up to date. Null: any of them may be. Only for
    // records without lists.
    u32 (*concerned)(Eval*, u32 catom, const void* before, const void* after, const i32* neighbours, u32 count, u32* out) = nullptr;
};

// One entry of a rows column. Rows are sorted, each row_bytes long.
struct RowsHead {
    u32 count;
    u32 capacity;  // Of the block; 0: the rows lie where they have arrived, or there are none.
    u8* data;
};
static_assert(sizeof(RowsHead) == kRowsHeadBytes);

// Linear facts that catoms of one thread send: for each column a run of entries, each a SentRow, the row, and a u32 for each receiver, its
// index.
struct SentRow {
    u32 from;   // Index of a catom.
    u32 count;  // Receivers, one or more.
};
// How long the part of an entry before its receivers is.
constexpr u64 sent_bytes(u64 row_bytes) { return sizeof(SentRow) + ((row_bytes + 3) & ~u64{3}); }
struct Outgoing {
    u8* next = nullptr;  // Where the next entry goes, if it ends before `end`.
    u8* end = nullptr;
    u64 sent = 0;  // Rows, one for each receiver.
    u64 said = 0;  // The same of facts that are in Broadcast::said instead.
};

// For a linear predicate that catoms tell all their neighbours alike (ModuleInfo::broadcasts): where each of them writes what it says, for
// its neighbours to read in the next tick, so that no rows are delivered. A catom has at most one entry a tick; what else it sends is rows.
// An entry is the round as a u64, which says whether it is of this tick or older, and the row. There is also one at -1, for a neighbour
// that is not there; nothing is said there.
struct Broadcast {
    const u8* heard = nullptr;  // [catom]: entries of the last tick, whose round is one less than that of this tick; null: there are none.
    u8* said = nullptr;         // [catom]: of this tick; null: everything goes as rows.
    u8* woken = nullptr;        // [catom]: set to 1 for each receiver, by several threads.
};
// How long an entry is.
constexpr u64 broadcast_bytes(u64 row_bytes) { return sizeof(u64) + ((row_bytes + 7) & ~u64{7}); }

// Rows that a column of one catom has lost and gained, each sorted by group; a row whose value changed is in both.
struct RowChanges {
    const RowChanges* next;  // Made earlier in the same tick.
    u32 removed;
    u32 added;
    // Rows of groups whose quarantine has ended. They concern only the catom itself: its neighbours skip them, because they are not sent to
    // other processes, and results must not depend on the processes.
    u32 woken;
    // 1, for Host::change_rows alone, of changes that remove nothing: after the rows, before which of the rows that were there each of the
    // added ones comes (places_of()).
    u32 placed;
    // Followed by the removed rows, the added rows, and the woken ones.
};
inline const u32* places_of(const RowChanges& changes, u64 row_bytes) {
    return reinterpret_cast<const u32*>(reinterpret_cast<const u8*>(&changes + 1) + ((changes.added * row_bytes + 3) & ~u64{3}));
}

struct ParameterInfo {  // A constant of the program that `--set` can change.
    const char* name;
    ValueType type;
    Value value;
    u16 deep;
    bool required;  // @arg1: the run must give it.
};

struct RuleInfo {
    const char* name;  // As in --explain-rules.
    const char* text;  // The rule as Meld.
    u32 line;
    const char* file;  // The file it comes from; empty: made by the compiler.
    u32 head_count;    // The predicates that it derives or makes, as in the program.
    const u16* heads;
    u64 at;  // The catom that the rule is for; for facts of the text, the greatest of their catoms; or kEverywhere.
    bool linear;
    u32 reads_there_count;  // The predicates that it reads at neighbours, each once.
    const u16* reads_there;
};
inline constexpr u64 kEverywhere = ~u64{0};

struct LinkInfo {  // A fact of a route that the program's text gives: edge(@0, @3).
    u16 predicate;
    u64 from, to;
    u32 line;
    const char* file;
};

// The share of one process, as a module sees it. The runtime owns all arrays.
struct SubdomainView {
    Geometry geometry;
    u8* const* columns = nullptr;  // [column]: the first catom's entry.
    // [column][catom]: the rows that changed since the catom's readers were last evaluated, or null. Null if the column does not record its
    // changes by row.
    const RowChanges* const* const* changes = nullptr;
    const Broadcast* broadcasts = nullptr;  // [column]; null: the module has none.
    u64 broadcast_round = 0;                // Of this tick.
    bool alone = true;                      // No other process has catoms.
    const Value* parameters = nullptr;
    i64 now = 0;  // The tick.
    u64 seed = 0;
    i64 world_catoms = 0;  // The number of catoms when the ensemble was made: @world.
    // Catoms with lower ids come from another run with the linear facts that they had then: kDirtyBorn gives them no others.
    u64 first_unborn = 0;
    double tick_seconds = 1e-3;
    u32 latency = 1;          // The bound on the latency of links, in ticks.
    u32 greatest_rank = 0;    // Of all facts that ever existed, on all processes, as of the last tick.
    bool tombstones = false;  // Whether this process may remember a loss.
    bool undefined = false;   // Whether some catom of this process has undefined derivations.
    bool strict = false;      // A derivation without a value ends the run at once.
    u64 max_derivations = 0;
    u64 max_facts = 0;
    // Of a recursion that only passes on the values it finds, which ends by itself.
    u64 max_finite_derivations = 0;
    // The same for rules that may derive ever more, because they compute arguments from what they have derived.
    u64 max_growing_derivations = 0;
    u64 max_growing_facts = 0;
    u64 max_list = kNone32;  // Maximum number of elements of a list, or of bytes of a string.
};

struct Tombstone {
    u32 least_rank;
    i64 time;
};

enum class Trap : u32 {
    None,
    Overflow,
    DivisionByZero,
    NotANumber,
    BadConversion,
    TooManyDerivations,
    TooManyFacts,
    BadIndex,
    TooDeep,
    TooLong,        // A list: its number of items and the maximum (SubdomainView::max_list).
    TooMuchMemory,  // Scratch memory of one catom's evaluation, in bytes.
    TextTooLong,    // A string: its number of bytes and the maximum.
    NotAnInt,       // A string that should contain an int.
    NotAFloat,
    NegativePower,  // Of an int: base and exponent.
    NothingBelow,   // The bound of a random int, which should be above 0.
    RankTooHigh,    // Of a fact: its rank and the maximum (kMaxRank).
};

// Whether it is a limit. A limit ends the run at once; any other trap in a view leaves out the derivation in which it happens.
constexpr bool is_limit(Trap trap) {
    return trap == Trap::TooManyDerivations || trap == Trap::TooManyFacts || trap == Trap::TooLong || trap == Trap::TextTooLong ||
           trap == Trap::TooMuchMemory || trap == Trap::RankTooHigh;
}

// The length of the string that a trap stores.
inline constexpr u32 kMaxTrapText_bytes = 32;

struct Host;
struct Counters;

// A variable of a rule, as the program names it, and the number of its type.
struct BoundVariable {
    const char* name;
    u16 type;
};

// One thread's evaluation.
struct Eval {
    const SubdomainView* subdomain = nullptr;
    const Host* host = nullptr;
    u32 catom = 0;
    u64 dirty = 0;        // Of the catom under evaluation.
    u8* arena = nullptr;  // Scratch memory, taken up to arena_end; each catom starts again at arena_start.
    u8* arena_start = nullptr;
    u8* arena_end = nullptr;
    u64 derivations = 0;  // Counted over the run.
    u64 dropped = 0;      // Linear facts for a neighbour that is no longer there.
    u64 far_facts = 0;    // Linear facts that set out for a node that no link need lead to,
    u64 far_hops = 0;     // and the messages by which such facts have come closer to it.
    u32 greatest_rank = 0;
    Trap trap = Trap::None;  // The first failure; evaluation of the catom is abandoned at its next check.
    u32 trap_rule = 0;
    Value trap_left = {}, trap_right = {};
    bool trap_real = false;                   // The operands are floats.
    char trap_text[kMaxTrapText_bytes] = {};  // The start of the string at fault; trap_left is its length in bytes.
    u32 draws = 0;                            // Random numbers drawn for this catom in this tick.
    u32 depth = 0;                            // Open calls of functions.
    u32 rule = kNone32;                       // The rule under evaluation, for failures that only the runtime notices; kNone32: none.
    u32 stratum = 0;                          // For views, the stratum under evaluation.
    u64 undefined = 0;                        // The strata of the catom that have undefined derivations, as undefined_bit().
    Outgoing* outgoing = nullptr;             // By column; without room for those that Host::send_row takes.
    Counters* counters = nullptr;             // For a module that counts (counts_abi.h).
    bool tells_firings = false;               // Host::fired is to be called.
    u32* still_activated = nullptr;           // Catoms of the block that keep the fact which they had for kDirtyTurn; room for all.
    u32 still_count = 0;                      // How many these are.
    u32 place = kNone32;                      // Of a module that says where it is; written and read as an atomic word, by two threads.
};
// The thread is at a rule, or at one of the places of counts_abi.h.
inline void note_place(Eval& e, u32 place) { __atomic_store_n(&e.place, place, __ATOMIC_RELAXED); }
constexpr u64 undefined_bit(u32 stratum) { return u64{1} << (stratum % 64); }

// The functions that the runtime provides to a module, for use within evaluate() only. All calls concern the catom under evaluation; the
// top of this file gives their order.
struct Host {
    // A new chunk of at least this many bytes becomes the arena; older chunks live until the block of catoms ends.
    void (*more_arena)(Eval*, u64 bytes);
    // The catom's record of a column becomes *record: at once for a private column, at the end of the tick for an exported one. A private
    // record without lists may also be written in place. From this call and those below on, the runtime owns the lists in its arguments: it
    // copies them from scratch memory, and counts its own.
    void (*export_record)(Eval*, u16 column, const void* record);
    // The catom's rows of a column become these: at once for a private column, at the end of the tick for an exported one.
    void (*assign_rows)(Eval*, u16 column, const void* rows, u32 count);
    // The same for an exported column that records its changes by row; applied at the end of the tick.
    void (*change_rows)(Eval*, u16 column, const RowChanges* changes);
    // A fact for a predicate of another catom (an index), delivered in the next tick.
    void (*send)(Eval*, u32 to, u16 predicate, const Value* arguments);
    // The same for a linear fact, as a row of its column. Rows without lists are written to Eval::outgoing instead, while there is room.
    void (*send_row)(Eval*, u32 to, u16 predicate, const void* row);
    // Where a fact for the catom with this id goes next: to itself, to a neighbour, or nowhere, which is the catom under evaluation.
    u64 (*next_hop)(Eval*, u64 target);
    // The same as send() for a catom by its id, without a link. False: the network sends nothing in that way, or it is gone; the fact is
    // dropped, and counted as such.
    bool (*send_far)(Eval*, u64 to, u16 predicate, const Value* arguments);
    // The id of a node that no catom has, in a graph; each call gives another one.
    u64 (*new_node)(Eval*);
    // A fact for a node with such an id of this evaluation: at the end of the tick the node is there, with all facts that it was given.
    void (*bear)(Eval*, u64 node, u16 predicate, const Value* arguments);
    // An action to be carried out in the next tick.
    void (*act)(Eval*, u16 predicate, const Value* arguments);
    // Evaluate the catom again at this tick.
    void (*wake)(Eval*, i64 tick, u64 dirty);
    // The same for one group of a predicate whose column records its changes by row: in that tick the row is among the changes, and
    // kDirtyGroups is set.
    void (*wake_group)(Eval*, i64 tick, u16 predicate, const void* row);
    // The losses of a group, including those of this evaluation; false: none, or none that still matters. Of predicate kNone16, whether the
    // catom remembers a loss of any group, also one that matters no longer; `out` stays as it is.
    bool (*tombstone)(Eval*, u16 predicate, u64 key, Tombstone* out);
    // A fact of the group with this rank has been retracted; stored from the end of the tick on.
    void (*lose)(Eval*, u16 predicate, u64 key, u32 rank);
    // 64 random bits for (seed, catom, tick, draw); counts the draw.
    u64 (*random)(Eval*);
    // The centre of the catom in diameters.
    void (*position)(Eval*, double out[3]);
    // The rotation nearest to a matrix; both row by row.
    void (*nearest_rotation)(const double matrix[9], double out[9]);
    // Sets Eval::undefined from the last evaluations of the catom's views.
    void (*undefined)(Eval*);
    // For the stratum under evaluation: Eval::trap belongs to a derivation that is left out. Stores it and clears the trap.
    void (*note_undefined)(Eval*);
    // The stratum under evaluation is derived again.
    void (*forget_undefined)(Eval*);
    // The rule of the catom's undefined derivation number `number`, in the order of rules; kNone32: there are no more.
    u32 (*undefined_rule)(Eval*, u32 number);
    // An action or a linear rule is about to read what this derivation makes uncertain: it becomes a trap.
    void (*stop_undefined)(Eval*, u32 number);
    // If Eval::tells_firings says so: a linear rule fires, with these values of its variables; nothing has been consumed yet.
    void (*fired)(Eval*, u32 rule, u32 count, const BoundVariable* variables, const Value* values);
    // For a checked module (kernel/check.h): something that its code takes for granted does not hold. Does not return.
    void (*broken)(Eval*, const char* condition, const char* file, i32 line);
    // Zeroed memory that takes none of the machine's until it is written to, so that what grows may ask for room that it may never need.
    // `needed` of these bytes will be written to in any case. Null: there is none, or scratch memory serves as well for so few. It lasts
    // until it is given back, or until another catom asks for some, or the block of catoms ends.
    void* (*reserve)(Eval*, u64 bytes, u64 needed);
    // The same of memory that was not reserved does nothing.
    void (*give_back)(Eval*, void* memory);
    // The same, but no other memory begins there until then: who has kept the place does not take other rows for those that were there.
    void (*empty)(Eval*, void* memory);
};

// A file of the program: its path relative to the program's folder, and its text.
struct SourceInfo {
    const char* path;
    const char* text;
};

struct ModuleInfo {
    u32 abi_version;
    u64 schema_hash;
    const char* program_name;
    u32 source_count;
    const SourceInfo* sources;  // The files that the program was read from, its own first.
    u32 program_count;          // How many of these are programs, which come first; a catom runs the rules of one of them. Usually 1.
    u32 include_count;
    const u32* includes;  // The source that each include and import means, in the order of reading; kNone32: a library of the compiler.
    u32 type_count;
    const TypeInfo* types;
    u32 predicate_count;
    const PredicateInfo* predicates;
    u32 column_count;
    const ColumnInfo* columns;
    u32 parameter_count;
    ParameterInfo const* parameters;
    u32 rule_count;
    const RuleInfo* rules;
    u32 link_count;
    const LinkInfo* links;  // In the order of the rules that give them.
    u32 named_count;
    const u64* named_nodes;  // The numbers of the nodes that the text names, as @7, ascending.
    bool reads_tick;         // Some rule reads `tick`: every catom is evaluated in every tick.
    // Evaluates catoms[0..count) to their local fixpoints, each with its dirty word.
    void (*evaluate)(Eval*, const u32* catoms, const u64* dirty, u32 count);
    bool counts;              // It counts what its rules do,
    bool places;              // or at least says where it is, as Eval::place (counts_abi.h).
    bool sends;               // Some rule sends linear facts.
    bool by_links;            // It finds neighbours in the tables of links, not by geometry (Geometry::link_first).
    bool waits;               // Some aggregate waits for its neighbours, in masks of ports: of 32 at most.
    bool for_graphs;          // It was compiled for graphs only,
    bool finds_ways;          // and some rule sends facts to nodes that no link need lead to,
    bool makes_nodes;         // or makes nodes.
    bool idle_births;         // No rule does anything at a catom where no fact holds, while nothing is read at its neighbours.
    bool own_graph;           // Without a world it runs in the graph of the nodes and links that its text names.
    u32 broadcast_count = 0;  // Of columns with a Broadcast.
    const u16* broadcasts = nullptr;
};

}  // namespace meld
