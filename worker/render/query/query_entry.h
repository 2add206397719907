#pragma once

#include "render/query/query_kernel.h"

namespace tessera::render::TESSERA_ISA {

const QueryKernel& query_kernel();

// implicit_value.cpp
double implicit_value(const ImplicitRecord& surface, const double (&p)[3]);

}  // namespace tessera::render::TESSERA_ISA
