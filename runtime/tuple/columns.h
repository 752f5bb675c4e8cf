// The columns of a module over the catoms of one part: records and rows, indexed by catom.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "runtime/abi/module_abi.h"
#include "runtime/tuple/row_pool.h"

namespace meld::tuple {

class Columns {
  public:
    // pools: how many threads may change rows at once.
    Columns(const ModuleInfo& module, int pools);
    ~Columns();
    Columns(const Columns&) = delete;
    Columns& operator=(const Columns&) = delete;

    // Makes room for this many catoms; entries that are new hold nothing. Pointers change.
    void resize(std::size_t catoms);
    std::size_t count() const { return count_; }
    // As Part::columns.
    u8* const* pointers() const { return pointers_.data(); }
    u8* entry(u32 column, u32 catom) const { return pointers_[column] + std::size_t{catom} * module_.columns[column].stride; }
    const RowsHead& rows(u32 column, u32 catom) const { return *reinterpret_cast<const RowsHead*>(entry(column, catom)); }

    // Replaces the rows of a catom, using this thread's pool. Rows may be the catom's own.
    void set_rows(u32 column, u32 catom, const void* rows, u32 count, int pool);
    // The catom holds nothing any more.
    void clear(u32 catom, int pool);

    enum class Which { All, Exported };
    // The catom's columns as bytes, and back into an entry that holds nothing.
    void pack(u32 catom, Which which, std::vector<std::byte>& out) const;
    const std::byte* unpack(u32 catom, Which which, const std::byte* from, int pool);
    // One column alone.
    void pack_column(u32 column, u32 catom, std::vector<std::byte>& out) const;
    const std::byte* unpack_column(u32 column, u32 catom, const std::byte* from, int pool);

    std::size_t bytes() const;

  private:
    void initialise(u32 column, std::size_t from, std::size_t to);

    const ModuleInfo& module_;
    std::vector<u8*> pointers_;
    std::size_t count_ = 0, capacity_ = 0;
    std::vector<RowPool> pools_;
};

}  // namespace meld::tuple
