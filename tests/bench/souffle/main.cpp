// Rules in Soufflé, compiled into C++, for tests/bench/bench_ascent.py. Usage: tables TASK FILE; each line of the file has the name of a
// relation and its numbers. Prints the CPU seconds of the rules, without reading the facts, and how many rows they have derived.
#include <souffle/SouffleInterface.h>

#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>

namespace {

double cpu_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

int main(int argc, char** argv) {
    souffle::SouffleProgram* const rules = argc == 3 ? souffle::ProgramFactory::newInstance(argv[1]) : nullptr;
    if (rules == nullptr) {
        std::fprintf(stderr, "usage: tables TASK FILE\n");
        return 2;
    }
    rules->setNumThreads(1);
    std::ifstream file(argv[2]);
    for (std::string line, name; std::getline(file, line);) {
        std::istringstream in(line);
        in >> name;
        souffle::Relation* const relation = rules->getRelation(name);
        souffle::tuple row(relation);
        for (std::size_t i = 0; i < relation->getArity(); ++i) {
            souffle::RamSigned number = 0;
            in >> number;
            row << number;
        }
        relation->insert(row);
    }
    const double before = cpu_seconds();
    rules->run();
    const double seconds = cpu_seconds() - before;
    std::size_t rows = 0;
    for (const souffle::Relation* const derived : rules->getOutputRelations()) rows += derived->size();
    std::printf("%.6f %zu\n", seconds, rows);
    delete rules;
    return 0;
}
