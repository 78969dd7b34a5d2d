// The error that a picture is expected to have, from what its samples say and from the picture itself.
//
// Methods tell an error for each pixel by how far parts of its samples disagree (OcclusionSum::errors): a part's error,
// scaled by the rate at which samples converge on edges in any direction. Where edges run straight, the whole set is
// better than its parts say, by up to eight times. There the picture knows better: neighbours have samples of their
// own, so that what is left of a few of them in a row when a linear slope is taken away is their noise. Where penumbra
// is curved, some of it is left too, along the edge least of all. Both words only err upwards, so the smaller counts,
// tile by tile: what its samples say, and the median of such differences in the direction where it is smallest. Pure.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/image/image.h"
#include "renderer/light/cpu_receivers.h"

namespace halfshade {

struct PictureError {
  double sum = 0;       // of |error| of visibility, over
  uint64_t pixels = 0;  // the shadowed ones
};

// `visibility_and_share`: [height][width][2], as FinishVisibility returns it. `errors`: OcclusionSum::errors, one a
// pixel. `pixels`: the receivers; null where neighbours' errors are not independent, so that errors alone count.
PictureError ExpectPictureError(const Image& visibility_and_share, const std::vector<float>& errors,
                                const CpuReceivers* pixels);

}  // namespace halfshade
