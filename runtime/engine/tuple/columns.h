// The columns of a module over the catoms of one process: records and rows, indexed by catom.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/engine/tuple/change_log.h"
#include "runtime/engine/tuple/row_pool.h"
#include "runtime/engine/tuple/values.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::tuple {

class ArrivedRows;

class Columns {
  public:
    // pools: how many threads may change rows at the same time.
    Columns(const ModuleInfo& module, int pools);
    ~Columns();
    Columns(const Columns&) = delete;
    Columns& operator=(const Columns&) = delete;

    // Makes room for this many catoms; new entries are empty, written by all workers if there are any. Pointers change.
    void resize(std::size_t catoms, Workers* workers = nullptr);
    std::size_t count() const { return count_; }
    // As SubdomainView::columns.
    u8* const* pointers() const { return pointers_.data(); }
    u8* entry(u32 column, u32 catom) const {
        MELD_EXPECT(column < module_.column_count && catom < count_, "column {} of catom {}, of {} and {}", column, catom,
                    module_.column_count, count_);
        return pointers_[column] + std::size_t{catom} * module_.columns[column].stride;
    }
    const RowsHead& rows(u32 column, u32 catom) const {
        MELD_EXPECT(module_.columns[column].rows, "column {} holds records", column);
        return *reinterpret_cast<const RowsHead*>(entry(column, catom));
    }

    // A column owns the stored lists that its records and rows point to. Lists that are written to it are copied or counted, unless the
    // caller has done so and hands them over. Rows that lie where they arrived (lie_at) may also point to lists that came with them, which
    // nobody owns and which end with the next delivery. Earlier values stay alive until release_dropped(), so that rows made of them can be
    // written to several columns in turn.
    enum class Lists { Keep, HandOver };
    // Replaces the record or the rows of a catom, using this thread's pool. Rows may be the catom's own.
    void set_record(u32 column, u32 catom, const void* record, int pool, Lists lists = Lists::Keep);
    // Inserts a row before the one at `at`, and keeps its lists too. Cost: the rows behind it are moved.
    void insert_row(u32 column, u32 catom, u32 at, const void* row, int pool);
    void set_rows(u32 column, u32 catom, const void* rows, u32 count, int pool, Lists lists = Lists::Keep);
    // The catom's rows are these from now on, which stay where they are; its rows until now are among them, with their stored lists.
    void lie_at(u32 column, u32 catom, u8* rows, u32 count, int pool);
    // Rows on their way to the columns of many catoms.
    ArrivedRows& arrived() { return *arrived_; }
    // The same if write(u8* record) changes part of the record.
    template <class Write>
    void change_record(u32 column, u32 catom, int pool, const Write& write) {
        u8* record = entry(column, catom);
        drop_lists(column, record, 1, pool);
        write(record);
        keep_lists(column, record, 1, pool);
    }
    // The same, and notes for the catom's readers which rows differ, if the changes of the column are recorded by row.
    void replace_rows(u32 column, u32 catom, const void* rows, u32 count, int pool);
    // Replaces the record or the rows of a catom by those of another one, without a note.
    void copy(u32 column, u32 from, u32 to, int pool);
    // Whether two catoms hold the same; lists by content.
    bool same(u32 column, u32 a, u32 b) const;
    // Notes a new row for the catom's readers.
    void note_added(u32 column, u32 catom, const void* row, int pool);
    // Notes for the catom itself a group to be looked at again.
    void note_woken(u32 column, u32 catom, const void* row, int pool);
    // Applies changes of rows and notes them for the readers. Rows that are already removed or already there change nothing.
    void change_rows(u32 column, u32 catom, RowChanges* changes, int pool);
    ChangeLog& changes() { return changes_; }
    const ChangeLog& changes() const { return changes_; }
    // Releases the lists that this pool's writes have replaced.
    void release_dropped(int pool);
    // Makes rows (or a record, count 1) of a column own their lists.
    void keep_lists(u32 column, u8* rows, u32 count, int pool);
    // The same, but only of lists that are stored already: what comes with a delivery stays nobody's.
    void share_lists(u32 column, const u8* rows, u32 count);
    // Makes rows own lists that came with them; the others they own already.
    void take_over_lists(u32 column, u8* rows, u32 count, int pool);
    ListStore& lists() { return lists_; }

    // The catom no longer holds anything.
    void clear(u32 catom, int pool);

    enum class Which { All, Exported };
    // The catom's columns as bytes, and back; lists by content.
    void pack(u32 catom, Which which, ByteWriter& out) const;
    void unpack(u32 catom, Which which, ByteReader& in, int pool);
    // The columns of some catoms for a snapshot, column by column, with the changes of rows that readers have not seen yet.
    void save(std::span<const u32> catoms, ByteWriter& out) const;
    // Back, of catoms that hold nothing yet. Of those that are ghosts here only what they export is read.
    void load(std::span<const SavedCatom> catoms, ByteReader& in);
    // One column only.
    void pack_column(u32 column, u32 catom, ByteWriter& out) const;
    void unpack_column(u32 column, u32 catom, ByteReader& in, int pool) {
        Unpacking room;
        unpack_column(column, catom, in, pool, room);
    }

    std::size_t bytes() const;
    // What so many catoms will take without rows, lists and changes of rows.
    static std::size_t bytes_for(const ModuleInfo& module, std::size_t catoms);
    // What a catom's rows take, if it has so many.
    static std::size_t row_bytes_for(const ColumnInfo& column, std::size_t rows) { return RowPool::capacity(rows * column.row_bytes); }

  private:
    // Memory for what is read, used again and again.
    struct Unpacking {
        std::vector<u8> rows;
        Arena lists;
    };
    void unpack_column(u32 column, u32 catom, ByteReader& in, int pool, Unpacking& room);
    void initialise(u32 column, std::size_t from, std::size_t to);
    void change_in_place(u32 column, u32 catom, const RowChanges& changes, int pool);
    void merge_changes(u32 column, u32 catom, const RowChanges& changes, int pool);
    void insert_rows(u32 column, u32 catom, const RowChanges& changes, int pool);
    // How many rows fit into the block for this many bytes.
    static u32 block_capacity(std::size_t bytes, std::size_t row_bytes);
    void erase_row(u32 column, u32 catom, u32 at);
    void save_records(u32 column, std::span<const u32> catoms, ByteWriter& out) const;
    void load_records(u32 column, std::span<const SavedCatom> catoms, ByteReader& in);
    void save_rows(u32 column, std::span<const u32> catoms, ByteWriter& out) const;
    void load_rows(u32 column, std::span<const SavedCatom> catoms, ByteReader& in);
    void drop_lists(u32 column, const u8* rows, u32 count, int pool);
    // Calls visit(list, type) for each list of rows or of a record.
    template <class Visit>
    void each_list(u32 column, const u8* rows, u32 count, const Visit& visit) const;

    const ModuleInfo& module_;
    std::vector<u8*> pointers_;
    std::size_t count_ = 0, capacity_ = 0;
    std::vector<RowPool> pools_;
    ListStore lists_;
    std::vector<std::vector<const List*>> dropped_;  // By pool
    ChangeLog changes_;
    std::unique_ptr<ArrivedRows> arrived_;
};

}  // namespace meld::tuple
