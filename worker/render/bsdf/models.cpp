#include "render/bsdf/bsdf.h"
#include "render/bsdf/coated_conductor.h"
#include "render/bsdf/coated_diffuse.h"
#include "render/bsdf/conductor.h"
#include "render/bsdf/dielectric.h"
#include "render/bsdf/diffuse.h"
#include "render/bsdf/diffuse_transmission.h"
#include "render/bsdf/hair.h"
#include "render/bsdf/interface.h"
#include "render/bsdf/plastic.h"
#include "render/bsdf/principled.h"
#include "render/bsdf/principled_thin.h"
#include "render/bsdf/thin_dielectric.h"

namespace tessera::render::TESSERA_ISA {

const Bsdf* bsdf_model(BsdfKind kind) {
  static const DiffuseBsdf diffuse;
  static const ConductorBsdf conductor;
  static const DielectricBsdf dielectric;
  static const ThinDielectricBsdf thin_dielectric;
  static const CoatedDiffuseBsdf coated_diffuse;
  static const CoatedConductorBsdf coated_conductor;
  static const DiffuseTransmissionBsdf diffuse_transmission;
  static const InterfaceBsdf interface;
  static const HairBsdf hair;
  static const PlasticBsdf plastic;
  static const PrincipledBsdf principled;
  static const PrincipledThinBsdf principled_thin;
  switch (kind) {
    case BsdfKind::kDiffuse:
      return &diffuse;
    case BsdfKind::kConductor:
      return &conductor;
    case BsdfKind::kDielectric:
      return &dielectric;
    case BsdfKind::kThinDielectric:
      return &thin_dielectric;
    case BsdfKind::kCoatedDiffuse:
      return &coated_diffuse;
    case BsdfKind::kDiffuseTransmission:
      return &diffuse_transmission;
    case BsdfKind::kInterface:
      return &interface;
    case BsdfKind::kPlastic:
      return &plastic;
    case BsdfKind::kCoatedConductor:
      return &coated_conductor;
    case BsdfKind::kHair:
      return &hair;
    case BsdfKind::kPrincipled:
      return &principled;
    case BsdfKind::kPrincipledThin:
      return &principled_thin;
    case BsdfKind::kMix:
    case BsdfKind::kCount:
      break;
  }
  return nullptr;
}

}  // namespace tessera::render::TESSERA_ISA
