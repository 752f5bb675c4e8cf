// Files of facts read table by table, in the forms that runtime/results/facts/facts_file.h writes. The facts of a table are in the order of
// catoms; one at a time is in memory.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "runtime/base/error.h"

namespace meld::record {

// As its line in text or CSV has it, without the line break; that of HDF5 as in CSV.
struct FactRow {
    std::uint64_t catom = 0;
    std::string text;
};

class FactsReader {
  public:
    struct Table {
        std::string name;
        std::size_t arguments = 0;  // The catom among them; 0 in tables, whose names differ.
        std::string columns = {};   // Their names, as in the first line of CSV; empty in text.
    };
    virtual ~FactsReader() = default;
    virtual const std::vector<Table>& tables() const = 0;
    // The rows of this table are next.
    virtual Result<void> begin(std::size_t table) = 0;
    // The next row; false after the last. Errors: it is no row of facts.
    virtual Result<bool> next(FactRow& row) = 0;
};

// "name(@12, ...)." lines. Cost: reads the file once to find the tables.
Result<std::unique_ptr<FactsReader>> read_text_facts(const std::string& path);
// A CSV file of one table, whose name is that of the file.
Result<std::unique_ptr<FactsReader>> read_csv_facts(const std::string& path);
Result<std::unique_ptr<FactsReader>> read_csv_folder(const std::string& path);
Result<std::unique_ptr<FactsReader>> read_hdf5_facts(const std::string& path);

}  // namespace meld::record
