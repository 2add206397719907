// Embree 3.13 or 4: the only file that knows the difference.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#define TESSERA_EMBREE 4
#else
#include <embree3/rtcore.h>
#define TESSERA_EMBREE 3
#endif

#include <cstdint>

namespace tessera::render {

#if TESSERA_EMBREE == 3
using EmbreeContext = RTCIntersectContext;
#else
using EmbreeContext = RTCRayQueryContext;
#endif

/// Context of callbacks of objects in objects: what they are told, and where they write. Places are numbered
/// by shape/place.h.
struct PlaceContext : EmbreeContext {
  std::int64_t holder = -1;       // place of the object whose scene is being searched; -1: the world's
  std::int64_t* found = nullptr;  // place of each ray's nearest hit in such an object, by the ray's id
};

/// kCoherent only for camera rays: measured to halve the speed of others. kSingle goes another way through
/// Embree, one ray at a time; it gives what packets give but for rounding, and is there to check them.
enum class Traversal { kCoherent, kIncoherent, kSingle };

/// Context of one trace call, besides the rays.
class TraceContext {
 public:
  explicit TraceContext(Traversal traversal, std::int64_t holder = -1, std::int64_t* found = nullptr) {
    const bool coherent = traversal == Traversal::kCoherent;
    context_.holder = holder;
    context_.found = found;
#if TESSERA_EMBREE == 3
    rtcInitIntersectContext(&context_);
    context_.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
#else
    rtcInitIntersectArguments(&intersect_);
    rtcInitOccludedArguments(&occluded_);
    rtcInitRayQueryContext(&context_);
    intersect_.context = occluded_.context = &context_;
    intersect_.flags = occluded_.flags =
        coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;
#endif
  }

#if TESSERA_EMBREE == 3
#define TESSERA_TRACE(width)                                                   \
  void intersect(const int* valid, RTCScene scene, RTCRayHit##width& packet) { \
    rtcIntersect##width(valid, scene, &context_, &packet);                     \
  }                                                                            \
  void occluded(const int* valid, RTCScene scene, RTCRay##width& packet) {     \
    rtcOccluded##width(valid, scene, &context_, &packet);                      \
  }
#else
#define TESSERA_TRACE(width)                                                   \
  void intersect(const int* valid, RTCScene scene, RTCRayHit##width& packet) { \
    rtcIntersect##width(valid, scene, &packet, &intersect_);                   \
  }                                                                            \
  void occluded(const int* valid, RTCScene scene, RTCRay##width& packet) {     \
    rtcOccluded##width(valid, scene, &packet, &occluded_);                     \
  }
#endif
  TESSERA_TRACE(16)
  TESSERA_TRACE(8)
  TESSERA_TRACE(4)
#undef TESSERA_TRACE

#if TESSERA_EMBREE == 3
  void intersect(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &context_, &ray); }
  void occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &context_, &ray); }
#else
  void intersect(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray, &intersect_); }
  void occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray, &occluded_); }
#endif

#if TESSERA_EMBREE == 3
  /// Streams are the fastest way for shadow rays where there are any (Embree 3).
  void occluded_stream(RTCScene scene, RTCRayNp& rays, unsigned count) {
    rtcOccludedNp(scene, &context_, &rays, count);
  }
#endif

 private:
  PlaceContext context_;
#if TESSERA_EMBREE == 4
  RTCIntersectArguments intersect_;
  RTCOccludedArguments occluded_;
#endif
};

}  // namespace tessera::render
