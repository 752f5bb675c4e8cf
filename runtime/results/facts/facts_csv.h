// Tables of facts as CSV: a line of names, then a line for each fact. Private to runtime/results.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "runtime/results/facts/facts_file.h"

namespace meld::record {

// The file beside the tables of a folder that tells the types of their columns: https://datapackage.org.
inline constexpr const char* kDataPackage = "datapackage.json";

// Numbers as they are, floats in the shortest form that reads back the same, true and false, catoms as their numbers; text as
// print_plain() has it, so that a fact is one line, and quoted.
void pack_csv(const ModuleInfo& module, const FactTable& table, u64 id, const Value* arguments, ByteWriter& out);

Result<std::unique_ptr<FactsFile>> open_csv(const std::string& path, const ModuleInfo& module, Durability durability);
Result<std::unique_ptr<FactsFile>> open_csv_folder(const std::string& path, const ModuleInfo& module, Durability durability);

}  // namespace meld::record
