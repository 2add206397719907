#include "render/bsdf/bsdf.h"

namespace tessera::render::TESSERA_ISA {
namespace {

constinit ModelTable<Bsdf, BsdfKind> models;

}  // namespace

const Bsdf* bsdf_model(BsdfKind kind) { return models[kind]; }

void set_model(BsdfKind kind, const Bsdf& model) { models.set(kind, model); }

BsdfKind add_bsdf(const Bsdf& model) { return models.add(model); }

}  // namespace tessera::render::TESSERA_ISA
