// Files with all facts of a state: as text in Meld syntax, as tables of CSV, or as tables of HDF5. The same bytes for any partition.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/base/files/output_file.h"
#include "runtime/results/facts/fact_tables.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::record {

// Csv is a file with the one table of a program, CsvFolder a folder with a file for each.
enum class FactsForm { Text, Csv, CsvFolder, Hdf5 };

// The form that a path asks for: .csv, a / at its end, .h5 or .hdf5; text otherwise.
FactsForm facts_form(const std::string& path);

// Before anything is done. Errors: the name promises a format that is none of these; it is a folder without the /; HDF5 cannot go to a
// stream.
Result<void> check_facts_path(const std::string& path);

// One form of such a file. Every process packs its facts, the one that writes has the file and gets them by table and catom.
class FactsFile {
  public:
    virtual ~FactsFile() = default;
    // The rows that follow are of this table. Each table comes once, also one without rows.
    virtual void begin(const FactTable& table) = 0;
    // The facts of one catom, as pack_fact() of this form has packed them.
    virtual void rows(std::span<const std::byte> packed) = 0;
    // All is written; the file gets its place. Errors: what could not be written, which is said here at the latest.
    virtual Result<void> commit() = 0;
};

// On the process that writes, before the run. Errors: the path cannot be written, or another process writes it; Csv: the program has
// several tables or none; CsvFolder: the folder has files of others.
Result<std::unique_ptr<FactsFile>> open_facts(const std::string& path, const ModuleInfo& module, Durability durability);

// Writes all facts, sorted by predicate, then catom id, then arguments; process 0 writes and alone has the file, all processes call.
// Auxiliary predicates and actions are left out. The file is committed.
// Errors, on every process: the file cannot be written. Cost: the facts of one predicate at a time pass through process 0.
Result<void> write_facts(sim::Subdomain& subdomain, FactsForm form, FactsFile* file);

}  // namespace meld::record
