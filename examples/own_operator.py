"""A crossover of your own beside the paper's, in the same algorithm on the same problem."""

import numpy as np
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.crossover import Crossover
from pymoo.optimize import minimize

from robolaser import find_robot
from robolaser.operators import ArithmeticCrossover, NonUniformMutation
from robolaser.problems import ScannerCalibration
from robolaser.simulation import paper


class BlendCrossover(Crossover):
    """BLX-α: each child uniform in the box that the parents span, wider by a share α on each side."""

    def __init__(self, alpha=0.3, prob=0.85, **kwargs):
        super().__init__(n_parents=2, n_offsprings=2, prob=prob, **kwargs)
        self.alpha = alpha

    def _do(self, problem, X, *args, random_state=None, **kwargs):
        low, high = X.min(axis=0), X.max(axis=0)  # X is (parents, matings, variables)
        margin = self.alpha * (high - low)
        children = random_state.uniform(low - margin, high + margin, X.shape)
        return np.clip(children, problem.xl, problem.xu)


problem = ScannerCalibration(paper(find_robot("scorbot_er7"), seed=1).dataset)
for crossover in (ArithmeticCrossover(prob=0.85), BlendCrossover()):
    algorithm = GA(pop_size=50, crossover=crossover, mutation=NonUniformMutation(prob_var=0.1, b=5))
    costs = [minimize(problem, algorithm, ("n_gen", 100), seed=seed).F[0] for seed in (1, 2, 3)]
    print(f"{type(crossover).__name__:<20} median J = {np.median(costs):.2e} m² of 3 runs")
