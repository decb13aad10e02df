// SPDX-License-Identifier: MIT
#pragma once

namespace pipewright::timing {

/// Bytes below the caller's frame that PaintStack paints, and so the most that StackUsed can say.
inline constexpr int kPaintedStack = 128 * 1024;

/// Paints the unused stack below the caller.
void PaintStack();

/// How far the paint has been overwritten since, told to the same caller: the stack that its calls
/// took at most, give or take the few words that this call takes itself. Says too little only where
/// the deepest call left its last words as the paint.
int StackUsed();

}  // namespace pipewright::timing
