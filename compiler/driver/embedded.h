// Texts that are part of meldc: the prelude and the headers that emitted code includes.
#pragma once

#include <span>

namespace meld::driver {

extern const char kPrelude[];
extern const char kGeometryAbi[];
extern const char kStorageAbi[];
extern const char kModuleAbi[];
extern const char kKernelValues[];
extern const char kKernelLists[];
extern const char kKernelLibrary[];
extern const char kKernelExactMean[];
extern const char kKernelRows[];
extern const char kKernelAggregates[];
extern const char kKernelViews[];
extern const char kKernelDeltas[];
extern const char kKernelFronts[];
extern const char kExtern[];

// stdlib/*.meld without the prelude, for `use "name"`.
struct EmbeddedLibrary {
    const char* name;
    const char* text;
};
extern const std::span<const EmbeddedLibrary> kLibraries;

}  // namespace meld::driver
