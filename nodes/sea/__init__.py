"""The sea: wave spectra as seeded sums of harmonics, and what water does to a floating body by frequency and heading.

spectra          spectra of irregular waves; their components with directions and phases
hydrodynamics    the file of a hull: added mass, radiation terms, wave loads; loads in a sea
radiation_fit    passive radiation terms from added mass and damping by frequency
coefficients     a hull from what Capytaine writes, or computes of a mesh
"""

from heavylift.kernel.on_demand import face

face(__name__)
