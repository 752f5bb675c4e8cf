// Tables of facts in an HDF5 file: each a dataset of rows with named, typed columns. Private to runtime/results.
#pragma once

#include <memory>

#include "runtime/results/facts/facts_file.h"

namespace meld::record {

void pack_hdf5(const ModuleInfo& module, const FactTable& table, u64 id, const Value* arguments, ByteWriter& out);

Result<std::unique_ptr<FactsFile>> open_hdf5(const std::string& path, const ModuleInfo& module, Durability durability);

}  // namespace meld::record
