// Facts as tables: which predicates have one, and its columns. Files of facts and recordings name them alike.
#pragma once

#include <string>
#include <vector>

#include "runtime/module/abi/module_abi.h"

namespace meld::record {

// What the cells of a column are. A vec3 takes three columns of numbers; strings, lists and whatever has parts stand as text.
enum class CellType { Int, Float, Bool, Node, Text };

struct TableColumn {
    std::string name;
    CellType type = CellType::Int;
    u16 argument = 0;  // After the catom.
    u16 item = 0;      // Of a vec3.
};

// The first column, which is not among these; and how many facts a catom has, where that is a column.
inline constexpr const char* kCatomColumn = "catom";
inline constexpr const char* kFactsColumn = "facts";

struct FactTable {
    std::string name;
    u32 predicate = 0;
    std::vector<TableColumn> columns;
};

// Whether users see the facts of a predicate: it is stored, none of the compiler's own and no action.
bool shown(const PredicateInfo& predicate);

// The name of an argument: as declared, or "arg2" for the second after the catom where it has none or not one of its own.
std::string argument_name(const PredicateInfo& predicate, u16 argument);

// "int", "list int": of a vec3's columns "float".
std::string column_type(const ModuleInfo& module, const FactTable& table, const TableColumn& column);

// The tables of all shown predicates, by name. Where several have one name, that of a table has the number of arguments too, the catom
// included: "p.2".
std::vector<FactTable> fact_tables(const ModuleInfo& module);

}  // namespace meld::record
