"""The sea: wave spectra as sums of harmonics drawn from a seed, and water loads on a floating body by frequency and
heading.

spectra          spectra of irregular waves; their components with directions and phases
extremes         quantiles of the largest values over seeds, with confidence
hydrodynamics    the file of a hull: added mass, radiation terms, wave loads; loads in a sea
radiation_fit    passive radiation model fitted to added mass and damping by frequency
coefficients     the file of a hull made from coefficients, or from a mesh by Capytaine
data_files       coefficients in files of WAMIT and Capytaine, with their conventions
nemoh_data       the same for files of NEMOH
prescribed       vessels on six joints that move as given harmonics
gap_damping      damping of the water between two hulls
hydrostatics     volume, centre of buoyancy and stiffness of a mesh
"""

from heavylift.kernel.on_demand import face

face(__name__)
