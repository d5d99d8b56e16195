"""Set-up of the whole test process: 64-bit JAX, so that formulas are tested where rounding does not hide them.

Scenes stay in float32 unless a test asks for float64.
"""

import jax

jax.config.update("jax_enable_x64", True)
