// Texts that are part of meldc: the prelude and the headers that emitted code includes.
#pragma once

namespace meld::driver {

extern const char kPrelude[];
extern const char kGeometryAbi[];
extern const char kModuleAbi[];
extern const char kModuleValues[];
extern const char kModuleLists[];
extern const char kModuleLibrary[];
extern const char kModuleEval[];
extern const char kModuleDeltas[];
extern const char kExtern[];

}  // namespace meld::driver
