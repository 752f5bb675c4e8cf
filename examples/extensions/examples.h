// Examples of the three kinds of extension. They are registered in register.cpp.
#pragma once

#include <memory>

#include "runtime/sim/core/extension.h"

std::unique_ptr<meld::sim::SimModule> make_census();
std::unique_ptr<meld::sim::CodeModule> make_odometer();
std::unique_ptr<meld::sim::CodeModule> make_pile();
std::unique_ptr<meld::sim::Component> make_tide();
