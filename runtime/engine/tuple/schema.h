// How a program stores its facts, apart from the program: so much of a ModuleInfo as it takes to read the columns of a snapshot when the
// program has changed since.
#pragma once

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::tuple {

class Schema {
  public:
    static void save(const ModuleInfo& module, ByteWriter& out);
    // Errors: the bytes describe no columns that could be.
    static Result<Schema> read(ByteReader& in);

    // Types, predicates and columns; everything else is empty. Valid as long as the schema, also when it is moved.
    const ModuleInfo& module() const { return *module_; }

  private:
    Schema() = default;
    bool read_types(ByteReader& in);
    bool read_predicates(ByteReader& in);
    bool read_columns(ByteReader& in);
    bool fits(const PredicateInfo& p) const;

    std::unique_ptr<ModuleInfo> module_;
    std::deque<std::string> names_;
    std::deque<std::vector<u16>> parts_, list_types_;
    std::deque<std::vector<u32>> list_offsets_;
    std::deque<std::vector<FieldInfo>> fields_;
    std::vector<TypeInfo> types_;
    std::vector<PredicateInfo> predicates_;
    std::vector<ColumnInfo> columns_;
};

// The predicate as a program declares it, without how it is aggregated: "linear token(node, int)".
std::string declaration(const ModuleInfo& module, const PredicateInfo& predicate);

}  // namespace meld::tuple
